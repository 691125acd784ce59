#include "host/light_section/pattern.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace selfproj {

FloatImage draw_pattern(const Rig& rig, std::span<const double> line_of_column) {
  if (line_of_column.size() != static_cast<std::size_t>(rig.projector.columns)) {
    throw std::invalid_argument("pattern: as many lines are needed as the projector has columns");
  }
  FloatImage pattern(rig.projector.lines, rig.projector.columns);
  const double half = 0.5 * rig.measure.line_width_px;
  for (int c = 0; c < pattern.columns; ++c) {
    const double center = line_of_column[static_cast<std::size_t>(c)];
    if (!(center + half > -0.5 && center - half < pattern.rows - 0.5)) {  // true for NaN, too
      continue;
    }
    const int first = std::max(0, static_cast<int>(std::floor(center - half + 0.5)));
    const int last = std::min(pattern.rows - 1, static_cast<int>(std::ceil(center + half - 0.5)));
    for (int r = first; r <= last; ++r) {
      const double covered = std::min(r + 0.5, center + half) - std::max(r - 0.5, center - half);
      pattern.row(r)[c] = static_cast<float>(std::max(0.0, covered));
    }
  }
  return pattern;
}

FloatImage draw_straight_line(const Rig& rig, double line) {
  return draw_pattern(rig, std::vector<double>(static_cast<std::size_t>(rig.projector.columns), line));
}

std::string encode_pattern_png(const FloatImage& pattern) {
  constexpr float kFull = 255;
  cv::Mat mat(pattern.rows, pattern.columns, CV_8UC1);
  for (int r = 0; r < pattern.rows; ++r) {
    std::transform(pattern.row(r), pattern.row(r) + pattern.columns, mat.ptr<std::uint8_t>(r), [](float value) {
      return static_cast<std::uint8_t>(std::lround(kFull * std::clamp(value, 0.0F, 1.0F)));
    });
  }
  std::vector<std::uint8_t> bytes;
  if (pattern.values.empty() || !cv::imencode(".png", mat, bytes)) {
    throw std::invalid_argument("pattern: an image of this size cannot be written as PNG");
  }
  std::string text(bytes.size(), '\0');
  std::memcpy(text.data(), bytes.data(), bytes.size());
  return text;
}

}  // namespace selfproj
