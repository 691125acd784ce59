#include "sim/scene/second_line.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

namespace selfproj {

double second_line_rows(const SecondLine& line, double way_mm) {
  return (line.least_rows + line.most_rows) / 2 +
         (line.most_rows - line.least_rows) / 2 * std::sin(2 * std::numbers::pi * way_mm / line.period_mm);
}

void add_second_line(const SecondLine& line, double way_mm, int rows, int columns, double without,
                     std::span<float> pixels) {
  const double distance = second_line_rows(line, way_mm);
  const int whole = static_cast<int>(std::floor(distance));
  const double f = distance - whole;
  const auto at = [&](int row, int column) {
    return row < 0
               ? 0.0
               : std::max(0.0, static_cast<double>(pixels[static_cast<std::size_t>(row * columns + column)]) - without);
  };
  for (int r = rows - 1; r >= 0; --r) {  // from below, so that what is reflected is still the first reflection
    for (int c = 0; c < columns; ++c) {
      pixels[static_cast<std::size_t>(r * columns + c)] +=
          static_cast<float>(line.share * ((1 - f) * at(r - whole, c) + f * at(r - whole - 1, c)));
    }
  }
}

}  // namespace selfproj
