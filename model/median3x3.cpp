#include "selfproj/model/median3x3.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>

#include "selfproj/model/gray_decoder.h"

namespace selfproj::model {
void median3x3(const std::uint16_t* codes, int rows, int columns, std::uint16_t* out) {
  if (rows < 1 || columns < 1) {
    throw std::invalid_argument("median3x3: rows or columns are less than 1");
  }
  if (codes == nullptr || out == nullptr) {
    throw std::invalid_argument("median3x3: null pointer");
  }
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      std::array<std::uint16_t, 9> values;
      int existing = 0;
      int measurable = 0;
      for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows - 1); ++r) {
        for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns - 1); ++c) {
          const std::uint16_t word = codes[static_cast<std::ptrdiff_t>(r) * columns + c];
          ++existing;
          if (is_measurable(word)) {
            values[static_cast<std::size_t>(measurable)] = word & kCodeMask;
            ++measurable;
          }
        }
      }
      std::uint16_t& result = out[static_cast<std::ptrdiff_t>(row) * columns + column];
      result = 0;
      if (2 * measurable > existing) {
        const auto middle = values.begin() + (measurable - 1) / 2;
        std::nth_element(values.begin(), middle, values.begin() + measurable);
        result = static_cast<std::uint16_t>(*middle | kCodeMeasurable);
      }
    }
  }
}

}  // namespace selfproj::model
