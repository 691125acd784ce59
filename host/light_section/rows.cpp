#include "host/light_section/rows.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"

namespace selfproj::light_section {
namespace {

constexpr int kPerRow = 4;  // centroids in a row
constexpr std::uint32_t kWeight = 1000;

double median_of(std::vector<double> values) {
  if (values.empty()) {
    return static_cast<double>(images::kNoValue);
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Frames whose starts come closer than this lose packets: the beats of a packet with exact columns and some clocks
// more. Columns that are divided leave RowBits + 12 clocks later, in a build for 1,023 rows.
double clocks_of_packet(const rig::RigMeasure& measure, int columns) {
  const std::size_t exact = model::packet_bytes(model::moments_payload_bytes(measure.mode, columns));
  const int more = measure.mode == model::Mode::binary ? 8 : measure.sends_compact() ? 14 + 10 + 12 : 14;
  return static_cast<double>(exact) / spec::kPacketBeatBytes + more;
}

std::size_t packet_size(const rig::Rig& rig, int columns) {
  return model::packet_bytes(rig.measure.sends_compact() ? model::compact_payload_bytes(columns)
                                                         : model::moments_payload_bytes(rig.measure.mode, columns));
}

}  // namespace

RowTable::RowTable(const rig::Rig& rig, const DifferentialProfiler& profiler, double lit_rows)
    : rows_(rig.camera.rows), half_line_(0.5 * lit_rows) {
  const auto count = static_cast<std::size_t>(profiler.columns());
  std::vector<std::uint32_t> m0(count, kWeight);
  std::vector<std::uint32_t> m1(count);
  // As many lit pixels as the rig takes, so that only the geometry decides; a line of few of them is not cut off.
  std::vector<std::uint32_t> n(count, static_cast<std::uint32_t>(std::max(rig.measure.min_lit_px, 1)));
  Profile profile;
  profile.resize(profiler.columns());
  std::vector<Column> columns(count);
  for (int step = kPerRow; step <= kPerRow * rows_; ++step) {
    std::fill(m1.begin(), m1.end(), static_cast<std::uint32_t>(step) * kWeight / kPerRow);
    profiler.profile(model::MomentsView{m0.data(), m1.data(), n.data()}, profile.view());
    for (std::size_t i = 0; i < count; ++i) {
      const bool valid = profile.validity[i] == static_cast<std::uint8_t>(Validity::valid);
      columns[i].height_mm.push_back(static_cast<double>(valid ? -profile.dz[i] : images::kNoValue));
    }
  }
  for (Column& column : columns) {
    // Where the difference is 0
    const std::vector<double>& h = column.height_mm;
    for (std::size_t k = 0; k + 1 < h.size(); ++k) {
      if (std::isfinite(h[k]) && std::isfinite(h[k + 1]) && (h[k] <= 0) != (h[k + 1] <= 0)) {
        column.reference_row = 1 + (static_cast<double>(k) + h[k] / (h[k] - h[k + 1])) / kPerRow;
        columns_.push_back(std::move(column));
        break;
      }
    }
  }
}

double RowTable::height_at(const Column& column, double centroid) const {
  const double at = std::clamp((centroid - 1) * kPerRow, 0.0, static_cast<double>(column.height_mm.size() - 1));
  const auto low = std::min(static_cast<std::size_t>(at), column.height_mm.size() - 2);
  const double share = at - static_cast<double>(low);
  return (1 - share) * column.height_mm[low] + share * column.height_mm[low + 1];
}

RowTable::Range RowTable::range(int first_row, int rows, double share) const {
  // The centroids of lines that leave the outermost rows of the region dark (line_is_cut_off)
  const double top = first_row + 1.5 + half_line_;
  const double bottom = first_row + rows - 0.5 - half_line_;
  std::vector<double> low;
  std::vector<double> high;
  for (const Column& column : columns_) {
    const double a = height_at(column, top);
    const double b = height_at(column, bottom);
    const bool inside = top <= bottom && column.reference_row >= top && column.reference_row <= bottom &&
                        std::isfinite(a) && std::isfinite(b);
    // A column that has not even its reference leaves nothing.
    low.push_back(inside ? std::min(a, b) : std::numeric_limits<double>::infinity());
    high.push_back(inside ? std::max(a, b) : -std::numeric_limits<double>::infinity());
  }
  if (low.empty()) {
    return {.low_mm = std::numeric_limits<double>::infinity(), .high_mm = -std::numeric_limits<double>::infinity()};
  }
  std::sort(low.begin(), low.end());
  std::sort(high.begin(), high.end(), std::greater<>());
  const auto last = static_cast<std::size_t>(std::ceil(share * static_cast<double>(low.size()))) - 1;
  return {.low_mm = low[std::min(last, low.size() - 1)], .high_mm = high[std::min(last, high.size() - 1)]};
}

RowTable::Choice RowTable::best(int rows, double share) const {
  Choice best{.first_row = 0, .range = range(0, rows, share)};
  for (int first = 1; first + rows <= rows_; ++first) {
    const Choice next{.first_row = first, .range = range(first, rows, share)};
    if (next.both_sides_mm() > best.both_sides_mm()) {
      best = next;
    }
  }
  return best;
}

double RowTable::mm_per_row() const {
  std::vector<double> slopes;
  for (const Column& column : columns_) {
    slopes.push_back(
        std::abs(height_at(column, column.reference_row + 0.25) - height_at(column, column.reference_row - 0.25)) /
        0.5);
  }
  return median_of(slopes);
}

double usual_lit_rows(const rig::Rig& rig) { return 0.5 * (rig.measure.min_lit_px + rig.measure.max_lit_px / 2.0); }

double centroid_noise(const rig::RigImaging& imaging, double peak, double lit_rows, double threshold) {
  constexpr int kPlaces = 8;  // of the line within a row
  const double line_sigma = lit_rows / 4;
  const int reach = static_cast<int>(std::ceil(lit_rows)) + 1;
  double of_all = 0;
  for (int place = 0; place < kPlaces; ++place) {
    const double centre = static_cast<double>(place) / kPlaces;
    double m0 = 0;
    double spread = 0;
    for (int r = -reach; r <= reach; ++r) {
      const double far = r - centre;
      const double grey = std::min(imaging.dark + peak * std::exp(-0.5 * far * far / (line_sigma * line_sigma)), 255.0);
      const double noise = std::max(std::hypot(imaging.read_noise, std::sqrt(grey / imaging.electrons_per_grey)), 1e-9);
      const double over = grey - threshold;
      const double z = over / noise;
      const double lit = 0.5 * std::erfc(-z / std::numbers::sqrt2);  // probability
      const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
      const double mean = over * lit + noise * density;
      m0 += mean;
      spread += far * far * ((over * over + noise * noise) * lit + over * noise * density - mean * mean);
    }
    of_all += spread / (m0 * m0) / kPlaces;
  }
  return std::isfinite(of_all) ? std::sqrt(of_all) : std::numeric_limits<double>::infinity();
}

double board_rate_hz(const rig::Rig& rig, int rows, int columns) {
  const double beats = rows * (columns / static_cast<double>(spec::kPixelsPerBeat));
  return rig.pixel_clock_hz() / std::max(beats, clocks_of_packet(rig.measure, columns));
}

double ethernet_rate_hz(const rig::Rig& rig, int columns) {
  constexpr double kBytesPerSecond = 125e6;
  constexpr double kLargest = 1472;                     // of UDP in a frame of Ethernet without fragments
  constexpr double kHeader = 16;                        // of a datagram (docs/packet-reference.md)
  constexpr double kAround = 8 + 14 + 4 + 12 + 20 + 8;  // preamble, Ethernet, check, gap, IP, UDP
  const double bytes = static_cast<double>(packet_size(rig, columns));
  const double datagrams = std::ceil(bytes / (kLargest - kHeader));
  return kBytesPerSecond / (bytes + datagrams * (kHeader + kAround));
}

}  // namespace selfproj::light_section
