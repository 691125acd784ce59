#include "host/capture/grey_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/text.h"
#include "selfproj/files/user_error.h"

namespace selfproj::capture {
namespace {

constexpr double kWhite = 255;

// The exponent of the power law nearest to the shares of light, by golden sections of the sum of squares. The squares
// are those of the light itself: in logarithms the dark levels, which are mostly noise, would count most.
double nearest_gamma(const std::vector<std::pair<double, double>>& shares) {
  const auto sum = [&](double gamma) {
    double squares = 0;
    for (const auto& [grey, light] : shares) {
      const double off = std::pow(grey, gamma) - light;
      squares += off * off;
    }
    return squares;
  };
  constexpr double kGolden = 0.6180339887498949;
  double low = 0.1;
  double high = 10;
  for (int i = 0; i < 60; ++i) {
    const double left = high - kGolden * (high - low);
    const double right = low + kGolden * (high - low);
    if (sum(left) < sum(right)) {
      high = right;
    } else {
      low = left;
    }
  }
  return (low + high) / 2;
}

}  // namespace

double GreyCurve::light_at(double grey) const {
  const auto after =
      std::find_if(points.begin() + 1, points.end() - 1, [&](const Point& point) { return point.grey >= grey; });
  const Point& low = *std::prev(after);
  return low.light + (grey - low.grey) / (after->grey - low.grey) * (after->light - low.light);
}

GreyTable linear_greys(const GreyCurve& curve) {
  const double dark = curve.light_at(0);
  const double bright = curve.light_at(255);
  GreyTable table{};
  int level = 0;
  for (int grey = 0; grey < 256; ++grey) {
    const double wanted = dark + (bright - dark) * grey / 255;
    const auto off = [&](int at) { return std::abs(curve.light_at(at) - wanted); };
    while (level < 255 && off(level + 1) <= off(level)) {  // light does not fall, so that the nearest only rises
      ++level;
    }
    table[static_cast<std::size_t>(grey)] = static_cast<std::uint8_t>(level);
  }
  table[0] = 0;
  return table;
}

GreyCurve load_grey_curve(const std::string& file) {
  std::istringstream text(files::read_text(file, files::kMostTextBytes));
  GreyCurve curve;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    if (line.ends_with('\r')) {
      line.pop_back();
    }
    if (number == 1) {
      if (line != "grey,light") {
        throw UserError(file, "does not begin with the line grey,light");
      }
      continue;
    }
    const std::size_t comma = std::min(line.find(','), line.size());
    const std::optional<double> grey = files::number_of_text<double>(line.substr(0, comma));
    const std::optional<double> light =
        files::number_of_text<double>(comma < line.size() ? line.substr(comma + 1) : "");
    if (!grey || !light || std::abs(*light) > 1e9) {
      throw UserError(file, fmt::format("line {}: is no pair grey,light", number));
    }
    if (!curve.points.empty() && (*grey <= curve.points.back().grey || *light < curve.points.back().light)) {
      throw UserError(file, fmt::format("line {}: grey must rise and light must not fall", number));
    }
    curve.points.push_back({*grey, *light});
  }
  if (curve.points.size() < 2 || curve.points.front().grey != 0 || curve.points.back().grey != 255) {
    throw UserError(file, "grey does not go from 0 to 255");
  }
  if (curve.points.back().light <= curve.points.front().light) {
    throw UserError(file, "light does not rise");
  }
  return curve;
}

std::string grey_curve_text(const GreyCurve& curve) {
  std::string text = "grey,light\n";
  for (const GreyCurve::Point& point : curve.points) {
    text += fmt::format("{:g},{:.6g}\n", point.grey, point.light);
  }
  return text;
}

std::vector<int> grey_levels(int levels) {
  std::vector<int> greys;
  for (int i = 0; i < levels; ++i) {
    greys.push_back(static_cast<int>(std::lround(kWhite * i / (levels - 1))));
  }
  return greys;
}

images::ImageSequence grey_patterns(const std::vector<int>& greys, int rows, int columns) {
  std::vector<std::string> names;
  for (const int grey : greys) {
    names.push_back(fmt::format("grey {}", grey));
  }
  return {std::move(names), [greys, rows, columns](std::size_t i) {
            const std::size_t pixels = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
            return images::Image{rows, columns, std::vector<std::uint8_t>(pixels, static_cast<std::uint8_t>(greys[i]))};
          }};
}

GreyResponse grey_response(const std::vector<int>& greys, const std::vector<images::Image>& images,
                           const std::string& camera) {
  constexpr int kMinLight = 30;
  constexpr int kMaxGrey = 250;
  constexpr std::size_t kMinPixels = 100;
  constexpr double kNoise = 0.01;
  const std::vector<std::uint8_t>& black = images.front().pixels;
  const std::vector<std::uint8_t>& white = images.back().pixels;
  std::vector<double> sums(images.size());
  GreyResponse response;
  for (std::size_t k = 0; k < white.size(); ++k) {
    if (white[k] - black[k] >= kMinLight && white[k] <= kMaxGrey) {
      ++response.pixels;
      for (std::size_t i = 0; i < images.size(); ++i) {
        sums[i] += images[i].pixels[k] - black[k];
      }
    }
  }
  if (response.pixels < kMinPixels) {
    throw UserError(camera, fmt::format("only {} pixels are lit by white and not saturated; {} are needed; change the "
                                        "exposure",
                                        response.pixels, kMinPixels));
  }
  const double full = sums.back();
  double last = 0;
  std::vector<std::pair<double, double>> shares;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (sums[i] < last - kNoise * full) {
      throw UserError(camera,
                      fmt::format("sees less light under grey {} than under grey {}; does other light change, or "
                                  "is an automatic setting of the camera or projector on?",
                                  greys[i], greys[i - 1]));
    }
    last = std::min(std::max(last, sums[i]), full);
    const double grey = greys[i] / kWhite;
    shares.emplace_back(grey, last / full);
    response.curve.points.push_back({static_cast<double>(greys[i]), last / static_cast<double>(response.pixels)});
    response.off_line = std::max(response.off_line, std::abs(last / full - grey));
  }
  response.gamma = nearest_gamma(shares);
  for (const auto& [grey, light] : shares) {
    response.off_law = std::max(response.off_law, std::abs(std::pow(grey, response.gamma) - light));
  }
  return response;
}

}  // namespace selfproj::capture
