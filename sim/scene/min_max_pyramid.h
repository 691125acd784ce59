// Finds the least and the greatest value of any rectangle of an image quickly.
#ifndef SELFPROJ_SIM_SCENE_MIN_MAX_PYRAMID_H
#define SELFPROJ_SIM_SCENE_MIN_MAX_PYRAMID_H

#include <algorithm>
#include <vector>

#include "host/images/float_image.h"

namespace selfproj {

class MinMaxPyramid {
 public:
  struct Range {
    float low, high;
  };

  MinMaxPyramid() = default;

  // The image must have pixels, and none may be NaN.
  explicit MinMaxPyramid(const FloatImage& image) {
    levels_.push_back({image, image});
    while (levels_.back().low.rows > 1 || levels_.back().low.columns > 1) {
      levels_.push_back(halved(levels_.back()));
    }
  }

  // Bounds of rows r0..r1 and columns c0..c1, both included and inside the image. They are sharp if the rectangle has
  // at most 4 pixels along each side. Otherwise they may include neighbours up to its own size away.
  [[nodiscard]] Range range(int r0, int r1, int c0, int c1) const {
    constexpr int kMost = 3;
    unsigned level = 0;
    while (std::max((r1 - r0) >> level, (c1 - c0) >> level) > kMost) {
      ++level;
    }
    const Level& l = levels_[level];
    Range result{l.low.row(r0 >> level)[c0 >> level], l.high.row(r0 >> level)[c0 >> level]};
    for (int r = r0 >> level; r <= r1 >> level; ++r) {
      const float* low = l.low.row(r);
      const float* high = l.high.row(r);
      for (int c = c0 >> level; c <= c1 >> level; ++c) {
        result = {std::min(result.low, low[c]), std::max(result.high, high[c])};
      }
    }
    return result;
  }

 private:
  struct Level {
    FloatImage low, high;
  };

  static Level halved(const Level& from) {
    const int rows = (from.low.rows + 1) / 2;
    const int columns = (from.low.columns + 1) / 2;
    Level to{FloatImage(rows, columns), FloatImage(rows, columns)};
    for (int r = 0; r < rows; ++r) {
      const int below = std::min(2 * r + 1, from.low.rows - 1);
      for (int c = 0; c < columns; ++c) {
        const int right = std::min(2 * c + 1, from.low.columns - 1);
        to.low.row(r)[c] = std::min({from.low.row(2 * r)[2 * c], from.low.row(2 * r)[right], from.low.row(below)[2 * c],
                                     from.low.row(below)[right]});
        to.high.row(r)[c] = std::max({from.high.row(2 * r)[2 * c], from.high.row(2 * r)[right],
                                      from.high.row(below)[2 * c], from.high.row(below)[right]});
      }
    }
    return to;
  }

  std::vector<Level> levels_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_MIN_MAX_PYRAMID_H
