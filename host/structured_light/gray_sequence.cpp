#include "selfproj/structured_light/gray_sequence.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace selfproj::structured_light {
namespace {

constexpr std::uint8_t kWhite = 255;

int checked(int side) {
  if (side < 1 || side > GraySequence::kMaxSide) {
    throw std::invalid_argument("Gray sequence: columns or rows out of range");
  }
  return side;
}

int bits_for(int values) { return std::max(1, static_cast<int>(std::bit_width(static_cast<unsigned>(values - 1)))); }

// The value that plane i of `bits`, positive or negative, shows at place v of the coded axis.
std::uint8_t value(int v, int bits, int plane, bool negative) {
  const auto code = static_cast<unsigned>(v);
  const bool bit = (((code ^ (code >> 1U)) >> static_cast<unsigned>(bits - 1 - plane)) & 1U) != 0;
  return bit != negative ? kWhite : 0;
}

}  // namespace

GraySequence::GraySequence(int columns, int rows)
    : columns_(checked(columns)), rows_(checked(rows)), column_bits_(bits_for(columns)), row_bits_(bits_for(rows)) {}

std::vector<std::uint8_t> GraySequence::image(int index) const {
  if (index < 0 || index >= count()) {
    throw std::out_of_range("Gray sequence: no such image");
  }
  const auto width = static_cast<std::size_t>(columns_);
  const auto height = static_cast<std::size_t>(rows_);
  std::vector<std::uint8_t> pixels(width * height, index == white() ? kWhite : 0);
  if (index >= white()) {
    return pixels;
  }
  const bool negative = index % 2 != 0;
  if (index < first_of_rows()) {
    for (std::size_t c = 0; c < width; ++c) {
      pixels[c] = value(static_cast<int>(c), column_bits_, index / 2, negative);
    }
    for (std::size_t r = 1; r < height; ++r) {
      std::copy_n(pixels.begin(), width, pixels.begin() + static_cast<std::ptrdiff_t>(r * width));
    }
    return pixels;
  }
  const int plane = (index - first_of_rows()) / 2;
  for (std::size_t r = 0; r < height; ++r) {
    std::fill_n(pixels.begin() + static_cast<std::ptrdiff_t>(r * width), width,
                value(static_cast<int>(r), row_bits_, plane, negative));
  }
  return pixels;
}

}  // namespace selfproj::structured_light
