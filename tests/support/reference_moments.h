// The definition of the column moments, written down once more in the plainest way and in 64 bits. Tests and benchmarks
// compare the model with it.
#ifndef SELFPROJ_TESTS_SUPPORT_REFERENCE_MOMENTS_H
#define SELFPROJ_TESTS_SUPPORT_REFERENCE_MOMENTS_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/column_moments.h"

namespace selfproj::test {

// The moments of one column (from 0) of `image`.
struct ReferenceMoments {
  std::uint64_t m0 = 0;
  std::uint64_t m1 = 0;
  std::uint64_t n = 0;
};

inline ReferenceMoments reference_moments(const ImageView& image, Mode mode, int threshold, int column) {
  ReferenceMoments sums;
  for (int row = 1; row <= image.rows; ++row) {
    const int pixel = image.pixels[(row - 1) * image.stride + column];
    if (pixel > threshold) {
      const int weight = mode == Mode::binary ? 1 : mode == Mode::grey ? pixel : pixel - threshold;
      sums.m0 += static_cast<std::uint64_t>(weight);
      sums.m1 += static_cast<std::uint64_t>(weight) * static_cast<std::uint64_t>(row);
      sums.n += 1;
    }
  }
  return sums;
}

// The number of columns of `found` that differ from the definition.
inline int wrong_columns(const ImageView& image, Mode mode, int threshold, const Moments& found) {
  int wrong = 0;
  for (int column = 0; column < image.columns; ++column) {
    const ReferenceMoments right = reference_moments(image, mode, threshold, column);
    const auto i = static_cast<std::size_t>(column);
    wrong += found.m0[i] != right.m0 || found.m1[i] != right.m1 || found.n[i] != right.n ? 1 : 0;
  }
  return wrong;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_REFERENCE_MOMENTS_H
