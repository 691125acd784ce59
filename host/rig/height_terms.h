// The terms of a correction of heights (height_correction.h).
#ifndef SELFPROJ_HOST_RIG_HEIGHT_TERMS_H
#define SELFPROJ_HOST_RIG_HEIGHT_TERMS_H

#include <algorithm>
#include <array>
#include <vector>

namespace selfproj {

// The greatest order that a rig may have.
inline constexpr int kMostOrder = 8;

// Degrees of the terms in column, row and height, in the order of RigHeights::corrections_mm: all whose sum is at most
// `order`, and whose degree in the height is at most `order_heights`.
inline std::vector<std::array<int, 3>> height_terms(int order, int order_heights) {
  std::vector<std::array<int, 3>> terms;
  for (int height = 0; height <= std::min(order, order_heights); ++height) {
    for (int row = 0; row + height <= order; ++row) {
      for (int column = 0; column + row + height <= order; ++column) {
        terms.push_back({column, row, height});
      }
    }
  }
  return terms;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_HEIGHT_TERMS_H
