// Folds (convolves) an image of sub-pixels with the kernel of the camera's lens and pixels, block by block, and only
// for the pixels that are asked for.
#ifndef SELFPROJ_SIM_SCENE_BLOCK_FOLD_H
#define SELFPROJ_SIM_SCENE_BLOCK_FOLD_H

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "sim/scene/block_grid.h"

namespace selfproj {

// Consecutive columns or rows, both ends included; none if the first is greater.
struct IndexSpan {
  int first = 0;
  int last = -1;

  [[nodiscard]] bool empty() const { return first > last; }
  void join(IndexSpan other) {
    if (!other.empty()) {
      *this = empty() ? other : IndexSpan{std::min(first, other.first), std::max(last, other.last)};
    }
  }
};

class BlockFold {
 public:
  // `kernel` is the lens_kernel of the blur that determines the grid's margin.
  BlockFold(const RigCamera& camera, const BlockGrid& grid, const std::vector<float>& kernel)
      : rows_(camera.rows), columns_(camera.columns), grid_(grid), kernel_(kernel) {}

  // For each row of pixels, those to which blocks contribute; `blocks` has one span for each row of blocks.
  [[nodiscard]] std::vector<IndexSpan> pixels_of(const std::vector<IndexSpan>& blocks) const;

  // For each row of blocks, those that contribute to pixels; `pixels` has one span for each row of pixels.
  [[nodiscard]] std::vector<IndexSpan> blocks_of(const std::vector<IndexSpan>& pixels) const;

  // Makes these pixels of an image, camera rows x columns. `values_of(down, across, values)` gives the values of each
  // block that contributes to them, row by row.
  template <class ValuesOf>
  void fold(const std::vector<IndexSpan>& pixels, const ValuesOf& values_of, std::span<float> image) const;

 private:
  [[nodiscard]] int taps() const { return static_cast<int>(kernel_.size()); }
  [[nodiscard]] std::ptrdiff_t stride() const { return static_cast<std::ptrdiff_t>(grid_.across()) * kBlockSide; }

  // The rows of pixels to which a row of sub-pixels contributes, from the first one of the margin.
  [[nodiscard]] IndexSpan rows_of(int sub_row) const {
    return {std::max(0, (sub_row - taps() + kSubPixels) / kSubPixels), std::min(rows_ - 1, sub_row / kSubPixels)};
  }

  // Folds a row of sums over sub-pixel rows along its columns.
  void fold_row(const float* sums, IndexSpan pixels, std::vector<float>& every, float* to) const;

  int rows_, columns_;
  BlockGrid grid_;
  std::vector<float> kernel_;
};

// Blocks are processed row by row. The kernel spreads each of their sub-pixel rows over the pixel rows around it. A
// pixel row that is complete is then folded along its columns.
template <class ValuesOf>
void BlockFold::fold(const std::vector<IndexSpan>& pixels, const ValuesOf& values_of, std::span<float> image) const {
  const std::vector<IndexSpan> blocks = blocks_of(pixels);
  std::vector<float> strip(static_cast<std::size_t>(stride()) * kBlockSide);
  const int open_rows = 2 * (grid_.margin() + kBlockPixels) + 1;  // most pixel rows that are incomplete at one time
  std::vector<float> sums(static_cast<std::size_t>(stride()) * static_cast<std::size_t>(open_rows), 0.0F);
  const auto sums_of = [&](int row) { return sums.data() + (row % open_rows) * stride(); };
  std::vector<float> every(static_cast<std::size_t>(stride() / kSubPixels));
  BlockValues values{};
  int done = 0;  // pixel rows that are complete
  for (int down = 0; down < grid_.down(); ++down) {
    const IndexSpan needed = blocks[static_cast<std::size_t>(down)];
    for (int across = needed.first; across <= needed.last; ++across) {
      values_of(down, across, values);
      for (int i = 0; i < kBlockSide; ++i) {
        std::copy_n(values.data() + i * kBlockSide, kBlockSide, strip.data() + i * stride() + across * kBlockSide);
      }
    }
    for (int i = 0; i < kBlockSide && !needed.empty(); ++i) {
      const float* from = strip.data() + i * stride();
      const int sub_row = down * kBlockSide + i;
      const IndexSpan rows = rows_of(sub_row);
      for (int row = rows.first; row <= rows.last; ++row) {
        const IndexSpan span = pixels[static_cast<std::size_t>(row)];
        const float weight = kernel_[static_cast<std::size_t>(sub_row - row * kSubPixels)];
        float* to = sums_of(row);
        const int end = span.empty() ? 0 : span.last * kSubPixels + taps();
        for (int c = span.first * kSubPixels; c < end; ++c) {
          to[c] += weight * from[c];
        }
      }
    }
    for (; done < rows_ && done * kSubPixels + taps() <= (down + 1) * kBlockSide; ++done) {
      const IndexSpan span = pixels[static_cast<std::size_t>(done)];
      if (!span.empty()) {
        fold_row(sums_of(done), span, every, image.data() + static_cast<std::ptrdiff_t>(done) * columns_);
        std::fill_n(sums_of(done), stride(), 0.0F);
      }
    }
  }
}

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BLOCK_FOLD_H
