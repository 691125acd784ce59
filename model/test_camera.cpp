#include "model/test_camera.h"

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::model {

namespace {

constexpr int kLineRows = 4;
constexpr int kStep = 8;  // columns after which the line is a row lower

void check_size(int columns, int rows) {
  if (columns <= 0 || columns % kStep != 0 || rows <= kLineRows) {
    throw std::invalid_argument("the test camera has a multiple of 8 columns, and five rows or more");
  }
}

}  // namespace

std::vector<std::uint8_t> test_camera_frame(int columns, int rows, std::uint32_t frame) {
  check_size(columns, rows);
  std::vector<std::uint8_t> pixels;
  pixels.reserve(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  const auto places = static_cast<std::uint32_t>(rows - kLineRows + 1);  // rows in which a line may begin
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const auto x = static_cast<std::uint32_t>(column);
      const int first = static_cast<int>((frame % places + x / kStep) % places);
      const std::uint32_t weight = (x + frame) % 64;
      std::uint32_t pixel = (x ^ static_cast<std::uint32_t>(row)) % 32;
      if (row >= first && row < first + kLineRows) {
        pixel = row == first ? 128 + weight : row == first + kLineRows - 1 ? 191 - weight : 255;
      }
      pixels.push_back(static_cast<std::uint8_t>(pixel));
    }
  }
  return pixels;
}

std::vector<std::uint8_t> test_camera_pattern(int columns, int rows, int bits, int index) {
  check_size(columns, rows);
  if (bits < 1 || bits > spec::kCodeCodeBits || index < 0 || index >= 2 * bits) {
    throw std::invalid_argument("the patterns of the test camera have 1 to 12 planes, a positive and a negative each");
  }
  constexpr std::uint8_t kNoCode = 128;
  const auto plane = static_cast<unsigned>(bits - 1 - index / 2);
  std::vector<std::uint8_t> pixels;
  pixels.reserve(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(rows); ++y) {
    for (std::uint32_t x = 0; x < static_cast<std::uint32_t>(columns); ++x) {
      const std::uint32_t code = (x + y) & ((1U << static_cast<unsigned>(bits)) - 1);
      const bool lit = ((code ^ code >> 1U) >> plane & 1U) != static_cast<std::uint32_t>(index % 2);
      const std::uint32_t shade = (x ^ y) % 32;
      const bool last_row = y + 1 == static_cast<std::uint32_t>(rows);
      pixels.push_back(last_row ? kNoCode : static_cast<std::uint8_t>(lit ? 255 - shade : shade));
    }
  }
  return pixels;
}

}  // namespace selfproj::model
