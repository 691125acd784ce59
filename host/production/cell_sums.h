// Points at any places, as the cells of an even grid.
#ifndef SELFPROJ_HOST_PRODUCTION_CELL_SUMS_H
#define SELFPROJ_HOST_PRODUCTION_CELL_SUMS_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "host/images/float_image.h"
#include "host/production/map_grid.h"

namespace selfproj {

// Each point gives its height to the four cells around it, by its nearness, and a cell is the mean of what it got.
// Memory is taken once.
class CellSums {
 public:
  CellSums() = default;
  explicit CellSums(const MapGrid& grid)
      : grid_(grid), sums_(2 * static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.columns)) {
    clear();
  }

  [[nodiscard]] const MapGrid& grid() const { return grid_; }

  void clear() {
    if (first_ <= last_) {
      const auto row = 2 * static_cast<std::ptrdiff_t>(grid_.columns);
      std::fill(sums_.begin() + first_ * row, sums_.begin() + (last_ + 1) * row, 0.0F);
    }
    first_ = grid_.rows;
    last_ = -1;
  }

  // Adds a point at a place in cells. A point outside of the grid is left out.
  void put(double row, double column, float height) {
    const int r = static_cast<int>(std::floor(row));
    const int c = static_cast<int>(std::floor(column));
    if (r < 0 || c < 0 || r + 1 >= grid_.rows || c + 1 >= grid_.columns) {
      return;
    }
    const auto fr = static_cast<float>(row - r);
    const auto fc = static_cast<float>(column - c);
    float* const at = sums_.data() + 2 * (static_cast<std::ptrdiff_t>(r) * grid_.columns + c);
    float* const below = at + 2 * static_cast<std::ptrdiff_t>(grid_.columns);
    const float w00 = (1 - fr) * (1 - fc);
    const float w01 = (1 - fr) * fc;
    const float w10 = fr * (1 - fc);
    const float w11 = fr * fc;
    at[0] += w00;
    at[1] += w00 * height;
    at[2] += w01;
    at[3] += w01 * height;
    below[0] += w10;
    below[1] += w10 * height;
    below[2] += w11;
    below[3] += w11 * height;
    first_ = std::min(first_, r);
    last_ = std::max(last_, r + 1);
  }

  // The cells so far, without rows at both ends that have no point.
  [[nodiscard]] HeightCells cells() const {
    constexpr float kLeastWeight = 0.25F;  // of a cell that counts: less is the mere shadow of a neighbour
    HeightCells result;
    result.grid = grid_;
    result.grid.rows = std::max(0, last_ - first_ + 1);
    result.grid.along_mm = grid_.along_of(std::min(first_, grid_.rows));
    result.height = FloatImage(result.grid.rows, grid_.columns, kNoValue);
    result.weight = FloatImage(result.grid.rows, grid_.columns);
    const float* from = sums_.data() + 2 * static_cast<std::ptrdiff_t>(first_) * grid_.columns;
    for (std::size_t i = 0; i < result.height.values.size(); ++i, from += 2) {
      result.weight.values[i] = from[0];
      if (from[0] >= kLeastWeight) {
        result.height.values[i] = from[1] / from[0];
      }
    }
    return result;
  }

 private:
  MapGrid grid_;
  int first_ = 0;  // rows that got a point
  int last_ = -1;
  std::vector<float> sums_;  // of weights and of heights, by turns
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_CELL_SUMS_H
