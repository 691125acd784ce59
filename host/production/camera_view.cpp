#include "host/production/camera_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "host/driver/clock.h"
#include "host/light_section/line_finder.h"
#include "selfproj/images/float_image.h"

namespace selfproj::production {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

using Histogram = std::array<std::size_t, 256>;

// The greatest value that at least a share of 1 % reaches.
int bright_of(const Histogram& greys) {
  std::size_t all = 0;
  for (const std::size_t count : greys) {
    all += count;
  }
  std::size_t above = 0;
  int grey = static_cast<int>(greys.size()) - 1;
  for (; grey > 0; --grey) {
    above += greys.at(static_cast<std::size_t>(grey));
    if (100 * above >= all) {
      break;
    }
  }
  return grey;
}

double share(std::size_t count, std::size_t all) {
  return all > 0 ? static_cast<double>(count) / static_cast<double>(all) : 0;
}

}  // namespace

std::vector<float> line_in_image(const model::ImageView& image, rig::Rig rig) {
  rig.camera.rows = image.rows;
  rig.camera.columns = image.columns;
  light_section::LineFinder finder(rig);
  finder.find(image);
  std::vector<float> line(finder.columns(), images::kNoValue);
  for (std::size_t c = 0; c < line.size(); ++c) {
    if (finder.has_line(c)) {
      line[c] = static_cast<float>(finder.centroid(c) - 1);  // moments count rows from 1
    }
  }
  return line;
}

ExposureFigures exposure_figures(const model::ImageView& image, const std::vector<float>& line,
                                 const rig::RigMeasure& measure) {
  const bool section = !line.empty();
  Histogram greys{};
  std::vector<std::uint8_t> brightest(static_cast<std::size_t>(image.columns), 0);
  for (int r = 0; r < image.rows; ++r) {
    const std::uint8_t* const row = image.pixels + static_cast<std::ptrdiff_t>(r) * image.stride;
    for (int c = 0; c < image.columns; ++c) {
      auto& most = brightest[static_cast<std::size_t>(c)];
      most = std::max(most, row[c]);
      if (!section) {
        ++greys[row[c]];
      }
    }
  }
  ExposureFigures figures;
  int min_bright = kMinBright;
  if (section) {
    std::size_t found = 0;
    std::size_t saturated = 0;
    for (std::size_t c = 0; c < line.size(); ++c) {
      if (!std::isnan(line[c])) {
        ++found;
        saturated += brightest[c] == UINT8_MAX ? 1 : 0;
        ++greys[brightest[c]];
      }
    }
    figures.saturated = share(saturated, found);
    figures.dark = share(line.size() - found, line.size());
    const int threshold = measure.threshold >> (measure.bits() - spec::kPixelBits);  // of the upper eight bits
    min_bright = std::max(min_bright, (threshold + UINT8_MAX) / 2);
  } else {
    const std::size_t all = static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.columns);
    std::size_t dark = 0;
    for (std::size_t grey = 0; grey < kDarkGrey; ++grey) {
      dark += greys[grey];
    }
    figures.saturated = share(greys.back(), all);
    figures.dark = share(dark, all);
  }
  figures.bright_grey = bright_of(greys);
  if (section && figures.dark > kMaxWithoutLine) {
    figures.advice = fmt::format("{:.0f} % of the columns have no line: is the projector on, and the threshold right?",
                                 100 * figures.dark);
  } else if (figures.saturated > kMaxSaturated) {
    figures.advice = fmt::format("too bright: {:.1f} % {} saturated; shorten the exposure", 100 * figures.saturated,
                                 section ? "of the line is" : "of the pixels are");
  } else if (figures.bright_grey < min_bright) {
    figures.advice =
        fmt::format("too dark: its brightest places have grey value {}; lengthen the exposure", figures.bright_grey);
  } else {
    figures.advice = "the exposure is right";
    figures.good = true;
  }
  return figures;
}

bool CameraView::add(const model::PacketView& packet, bool wanted) {
  if (packet.header.kind != spec::kKindImage) {
    return false;
  }
  if (!begun_) {
    const std::int64_t now = driver::now_ns();
    if (packet.header.first_line != 1 || now < next_ns_ || !wanted) {
      return false;
    }
    begun_ = true;
    next_ns_ = now + kSecondNs / kPerSecond;
  }
  const std::uint64_t broken = images_.incomplete();
  if (images_.add(packet)) {
    begun_ = false;
    return true;
  }
  if (images_.incomplete() != broken) {
    begun_ = false;  // the next one will do
    next_ns_ = 0;
  }
  return false;
}

}  // namespace selfproj::production
