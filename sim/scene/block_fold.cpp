#include "sim/scene/block_fold.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace selfproj {

std::vector<IndexSpan> BlockFold::pixels_of(const std::vector<IndexSpan>& blocks) const {
  std::vector<IndexSpan> pixels(static_cast<std::size_t>(rows_));
  for (int row = 0; row < rows_; ++row) {
    IndexSpan near;
    for (int down = row * kSubPixels / kBlockSide; down <= (row * kSubPixels + taps() - 1) / kBlockSide; ++down) {
      near.join(blocks[static_cast<std::size_t>(down)]);
    }
    if (!near.empty()) {
      pixels[static_cast<std::size_t>(row)] = {
          std::max(0, (near.first * kBlockSide - taps() + kSubPixels) / kSubPixels),
          std::min(columns_ - 1, ((near.last + 1) * kBlockSide - 1) / kSubPixels)};
    }
  }
  return pixels;
}

std::vector<IndexSpan> BlockFold::blocks_of(const std::vector<IndexSpan>& pixels) const {
  std::vector<IndexSpan> blocks(static_cast<std::size_t>(grid_.down()));
  for (int row = 0; row < rows_; ++row) {
    const IndexSpan span = pixels[static_cast<std::size_t>(row)];
    if (span.empty()) {
      continue;
    }
    const IndexSpan needed{span.first * kSubPixels / kBlockSide, (span.last * kSubPixels + taps() - 1) / kBlockSide};
    for (int down = row * kSubPixels / kBlockSide; down <= (row * kSubPixels + taps() - 1) / kBlockSide; ++down) {
      blocks[static_cast<std::size_t>(down)].join(needed);
    }
  }
  return blocks;
}

void BlockFold::fold_row(const float* sums, IndexSpan pixels, std::vector<float>& every, float* to) const {
  const int end = pixels.last + 1;
  std::fill(to + pixels.first, to + end, 0.0F);
  const auto last = static_cast<std::size_t>(pixels.last + (taps() - 1) / kSubPixels);
  for (int phase = 0; phase < kSubPixels; ++phase) {  // takes every kSubPixels-th sub-pixel
    for (auto c = static_cast<std::size_t>(pixels.first); c <= last; ++c) {
      every[c] = sums[c * kSubPixels + static_cast<std::size_t>(phase)];
    }
    for (int k = phase; k < taps(); k += kSubPixels) {
      const float weight = kernel_[static_cast<std::size_t>(k)];
      const float* shifted = every.data() + k / kSubPixels;
      for (int c = pixels.first; c < end; ++c) {
        to[c] += weight * shifted[c];
      }
    }
  }
}

}  // namespace selfproj
