#include "host/structured_light/code_borders.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <vector>

#include "host/structured_light/check.h"
#include "selfproj/model/gray_decoder.h"

namespace selfproj::structured_light {
namespace {

// Returns 1 if depth grows with the code, and -1 if it falls or if no pixel decides. It compares the depths of the
// two middle codes at the first pixel that has both.
float direction(const Triangulation& triangulation) {
  const std::size_t pixels = triangulation.pixels();
  const auto middle = static_cast<std::uint16_t>(1 << (triangulation.bits() - 1));
  std::vector<float> before(pixels);
  std::vector<float> after(pixels);
  const std::vector<std::uint16_t> low(pixels,
                                       static_cast<std::uint16_t>((middle - 1) | model::GrayDecoder::kMeasurable));
  const std::vector<std::uint16_t> high(pixels, static_cast<std::uint16_t>(middle | model::GrayDecoder::kMeasurable));
  triangulation.depth(low.data(), before.data());
  triangulation.depth(high.data(), after.data());
  for (std::size_t i = 0; i < pixels; ++i) {
    if (!std::isnan(before[i]) && !std::isnan(after[i])) {
      return after[i] > before[i] ? 1 : -1;
    }
  }
  return -1;
}

}  // namespace

CodeBorders::CodeBorders(const Triangulation& triangulation, int threshold)
    : triangulation_(triangulation),
      threshold_(threshold),
      towards_(direction(triangulation)),
      difference_(static_cast<std::size_t>(triangulation.bits())),
      whole_(triangulation.pixels()) {
  check(triangulation.rows_are_x(), "borders between codes: the codes must change from row to row of the projector");
  check(threshold >= 0 && threshold <= 255, "borders between codes: the threshold is not in 0..255");
}

void CodeBorders::add_plane(int plane, const model::ImageView& positive, const model::ImageView& negative) {
  check(plane >= 0 && plane < triangulation_.bits(), "borders between codes: there is no such plane");
  const int rows = triangulation_.rows();
  const int columns = triangulation_.columns();
  for (const model::ImageView& image : {positive, negative}) {
    check(image.pixels != nullptr && image.rows == rows && image.columns == columns,
          "borders between codes: an image has another size");
  }
  std::vector<std::int16_t>& difference = difference_[static_cast<std::size_t>(plane)];
  difference.resize(triangulation_.pixels());
  for (int r = 0; r < rows; ++r) {
    const std::uint8_t* p = positive.pixels + r * positive.stride;
    const std::uint8_t* n = negative.pixels + r * negative.stride;
    std::int16_t* to = difference.data() + static_cast<std::ptrdiff_t>(r) * columns;
    for (int c = 0; c < columns; ++c) {
      to[c] = static_cast<std::int16_t>(p[c] - n[c]);
    }
  }
}

void CodeBorders::depth(const std::uint16_t* codes, float* z) {
  const auto columns = static_cast<std::size_t>(triangulation_.columns());
  triangulation_.depth(codes, whole_.data());
  std::fill(z, z + whole_.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t here = 0; here + columns < whole_.size(); ++here) {
    const std::size_t next = here + columns;  // the same column of the next row
    const int code = codes[here] & model::GrayDecoder::kCode;
    const int step = (codes[next] & model::GrayDecoder::kCode) - code;
    if (std::abs(step) != 1 || std::isnan(whole_[here]) || std::isnan(whole_[next])) {
      continue;
    }
    // The bit of the Gray code in which the two codes differ
    const int bit = std::countr_zero(static_cast<unsigned>(std::max(code, code + step)));
    const auto& difference = difference_[static_cast<std::size_t>(triangulation_.bits() - 1 - bit)];
    if (difference.empty()) {
      continue;
    }
    const int a = difference[here];
    const int b = difference[next];
    if ((a < 0) == (b < 0) || std::abs(a - b) <= 2 * threshold_) {
      continue;
    }
    // The border is half a code from the middle of either code, and rounding_error() is 1/√12 of a code.
    const float half = towards_ * static_cast<float>(0.5 * step * 2 * std::numbers::sqrt3);
    const float before = whole_[here] + half * static_cast<float>(triangulation_.rounding_error(here, whole_[here]));
    const float after = whole_[next] - half * static_cast<float>(triangulation_.rounding_error(next, whole_[next]));
    const float share = static_cast<float>(a) / static_cast<float>(a - b);
    z[share < 0.5F ? here : next] = before + share * (after - before);
  }
}

}  // namespace selfproj::structured_light
