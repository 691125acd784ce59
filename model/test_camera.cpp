#include "model/test_camera.h"

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace selfproj {

std::vector<std::uint8_t> test_camera_frame(int columns, int rows, std::uint32_t frame) {
  constexpr int kLineRows = 4;
  constexpr int kStep = 8;  // columns after which the line is a row lower
  if (columns <= 0 || columns % kStep != 0 || rows <= kLineRows) {
    throw std::invalid_argument("the test camera has a multiple of 8 columns, and five rows or more");
  }
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

}  // namespace selfproj
