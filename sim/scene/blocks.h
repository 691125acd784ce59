// The blocks of pixels into which an image is divided, the lens that folds their sub-pixels, and what of them is the
// same in many frames.
#ifndef SELFPROJ_SIM_SCENE_BLOCKS_H
#define SELFPROJ_SIM_SCENE_BLOCKS_H

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/optics.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"

namespace selfproj::sim {

// The blocks of pixels into which an image is divided, with the margin around it that the lens gathers light from.

inline constexpr int kBlockPixels = 4;                              // along a side of a block
inline constexpr int kBlockSide = kBlockPixels * kSubPixels;        // sub-pixels along a side of a block
inline constexpr int kBlockSamples = kBlockSide * kBlockSide;       // sub-pixels in a block
using BlockValues = std::array<float, std::size_t{kBlockSamples}>;  // grey values of a block's sub-pixels, row by row

// Blocks, and nodes at their corners, in the middles of their sides and in their middles. Node (2 down, 2 across) is
// the upper left corner of block (down, across).
class BlockGrid {
 public:
  BlockGrid(const rig::RigCamera& camera, int margin)
      : margin_(margin),
        down_((camera.rows + 2 * margin + kBlockPixels - 1) / kBlockPixels),
        across_((camera.columns + 2 * margin + kBlockPixels - 1) / kBlockPixels) {}

  [[nodiscard]] int margin() const { return margin_; }  // in pixels
  [[nodiscard]] int down() const { return down_; }      // in blocks
  [[nodiscard]] int across() const { return across_; }
  [[nodiscard]] int nodes_down() const { return 2 * down_ + 1; }
  [[nodiscard]] int nodes_across() const { return 2 * across_ + 1; }
  [[nodiscard]] std::size_t blocks() const { return block(down_, 0); }
  [[nodiscard]] std::size_t nodes() const { return node(nodes_down(), 0); }

  // Indices, row by row.
  [[nodiscard]] std::size_t block(int down, int across) const {
    return static_cast<std::size_t>(down * across_ + across);
  }
  [[nodiscard]] std::size_t node(int down, int across) const {
    return static_cast<std::size_t>(down * nodes_across() + across);
  }
  [[nodiscard]] std::size_t block_of_pixel(int row, int column) const {
    return block((row + margin_) / kBlockPixels, (column + margin_) / kBlockPixels);
  }

  // Places in the image. Pixel (r, c) extends from r - 0.5 to r + 0.5.
  [[nodiscard]] PixelPoint node_pixel(int down, int across) const {
    constexpr double kStep = kBlockPixels / 2.0;
    return {down * kStep - margin_ - 0.5, across * kStep - margin_ - 0.5};
  }
  // The middle of sub-pixel (i, j) of a block.
  [[nodiscard]] PixelPoint sample_pixel(int down, int across, int i, int j) const {
    return {down * kBlockPixels - margin_ - 0.5 + (i + 0.5) / kSubPixels,
            across * kBlockPixels - margin_ - 0.5 + (j + 0.5) / kSubPixels};
  }

 private:
  int margin_, down_, across_;
};

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

// The grey values of a row of blocks, sub-pixel by sub-pixel, less those of a dark surface. Outside of the columns
// first..last - 1 they are 0.
struct SubPixelStrip {
  explicit SubPixelStrip(const BlockGrid& grid)
      : width(grid.across() * kBlockSide), samples(static_cast<std::size_t>(width) * std::size_t{kBlockSide}) {}

  [[nodiscard]] float* row(int i) { return samples.data() + static_cast<std::ptrdiff_t>(i) * width; }
  [[nodiscard]] const float* row(int i) const { return samples.data() + static_cast<std::ptrdiff_t>(i) * width; }

  int width;
  int first = 0;
  int last = 0;
  std::vector<float> samples;
};

// Folds (convolves) an image of sub-pixels with the kernel of the camera's lens and pixels, block by block, and only
// for the pixels that are asked for.
class BlockFold {
 public:
  // The lens's blur, a standard deviation in pixels, determines kernel and margin.
  BlockFold(const rig::RigCamera& camera, double blur)
      : rows_(camera.rows), columns_(camera.columns), grid_(camera, lens_margin(blur)), kernel_(lens_kernel(blur)) {}

  [[nodiscard]] const BlockGrid& grid() const { return grid_; }

  // For each row of pixels, those to which blocks contribute; `blocks` has one span for each row of blocks.
  [[nodiscard]] std::vector<IndexSpan> pixels_of(const std::vector<IndexSpan>& blocks) const;

  // For each row of blocks, those that contribute to pixels; `pixels` has one span for each row of pixels.
  [[nodiscard]] std::vector<IndexSpan> blocks_of(const std::vector<IndexSpan>& pixels) const;

  // Makes these pixels of an image, camera rows x columns. `values_of(down, across, values)` gives the values of each
  // block that contributes to them, row by row.
  template <class ValuesOf>
  void fold(const std::vector<IndexSpan>& pixels, const ValuesOf& values_of, std::span<float> image) const;

  // Adds the contributions of a row of blocks to an image. For images of which little is lit: it sums along columns
  // first, and so rounds otherwise than fold().
  void add(const SubPixelStrip& strip, int down, std::span<float> image) const;

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

// What is the same in every frame for the blocks of an image: their sights, and the heights of the surface at which
// light of the pattern may fall on what they show.
class BlockViews {
 public:
  // `heights` are those that the surface can have. For others may_be_lit is always true.
  BlockViews(const PerturbedRig& actual, const BlockGrid& grid, HeightRange heights);

  // Prepares may_be_lit for a pattern. No other thread may call it meanwhile.
  void set_light(const ProjectedLight& light);

  // Whether no light falls on the points that the rays through a block meet between these heights.
  [[nodiscard]] bool is_dark(std::size_t block, HeightRange heights, const ProjectedLight& light) const;

  // False only if the light of set_light cannot fall on those points. It is a look-up, by slices of the heights.
  [[nodiscard]] bool may_be_lit(std::size_t block, HeightRange heights) const {
    if (!(heights.low >= heights_.low && heights.high <= heights_.high)) {
      return true;
    }
    const unsigned first = slice_of(heights.low);
    const unsigned last = std::max(first, slice_of(heights.high));
    const std::uint32_t from_low = ~std::uint32_t{0} << first;
    const std::uint32_t to_high = ~std::uint32_t{0} >> (kSlices - 1 - last);
    return (lit_[block] & from_low & to_high) != 0;
  }

  // The sights of a block's corners, and bounds of x and y of all its sights.
  [[nodiscard]] const std::array<Point3, 4>& corners(std::size_t block) const { return corners_[block]; }
  [[nodiscard]] const Box& tangents(std::size_t block) const { return tangents_[block]; }

 private:
  static constexpr unsigned kSlices = 32;  // of the heights, one for each bit

  [[nodiscard]] unsigned slice_of(double height) const {
    const auto slice = static_cast<unsigned>((height - heights_.low) * slices_per_mm_);
    return slice < kSlices ? slice : kSlices - 1;
  }
  [[nodiscard]] std::uint32_t lit_slices(std::size_t block, const ProjectedLight& light, unsigned first,
                                         unsigned count) const;

  double plane_z_;
  Point3 centre_;  // of the camera
  Pinhole projector_;
  HeightRange heights_;
  double slices_per_mm_;
  std::vector<std::array<Point3, 4>> corners_;
  std::vector<Box> tangents_;
  std::vector<std::uint32_t> lit_;  // for each block, the slices in which light may fall on it
};

// Grey values of level blocks in the light, kept by their height: a part's top shows the same in every frame in which
// it lies under a block.

// Several threads may call it at once.
class LevelBlocks {
 public:
  struct Kept {
    double height;
    std::vector<float> values;  // as many as BlockValues has; none if no light falls on the block at this height

    [[nodiscard]] bool dark() const { return values.empty(); }
  };

  explicit LevelBlocks(std::size_t blocks) : slots_(blocks) {}

  // What is kept of a block at this height; null if nothing is. Valid as long as this object.
  [[nodiscard]] const Kept* find(std::size_t block, double height) const {
    for (const std::atomic<const Kept*>& slot : slots_[block]) {
      const Kept* const kept = slot.load(std::memory_order_acquire);
      if (kept == nullptr || kept->height == height) {
        return kept;
      }
    }
    return nullptr;
  }

  // Keeps it, unless kHeights heights of the block are kept already.
  void keep(std::size_t block, Kept kept) {
    const std::lock_guard lock(mutex_);
    for (std::atomic<const Kept*>& slot : slots_[block]) {
      const Kept* const other = slot.load(std::memory_order_relaxed);
      if (other == nullptr) {
        slot.store(&all_.emplace_back(std::move(kept)), std::memory_order_release);
        return;
      }
      if (other->height == kept.height) {
        return;
      }
    }
  }

  static constexpr std::size_t kHeights = 4;

 private:
  std::vector<std::array<std::atomic<const Kept*>, kHeights>> slots_;  // of a block, the first ones filled
  std::deque<Kept> all_;
  std::mutex mutex_;
};

// What the columns of a camera see, from edge to edge of their pixels: the same in every frame.

// Several threads may call it at once. The sights are found when they are first needed.
class ColumnViews {
 public:
  ColumnViews(const Pinhole& camera, const rig::RigCamera& size)
      : camera_(camera), rows_(size.rows), columns_(size.columns), parts_((size.rows + kPart - 1) / kPart) {}

  static constexpr int kPart = 16;  // rows of a part of a column; the last one may have fewer

  [[nodiscard]] int parts() const { return parts_; }
  [[nodiscard]] int first_row(int part) const { return part * kPart; }
  [[nodiscard]] int rows_of(int part) const { return std::min(kPart, rows_ - part * kPart); }

  // The camera's sights at the upper edge of each row of a part, and at the lower edge of the last one.
  [[nodiscard]] std::span<const Point3> edges(int column, int part) const {
    fill();
    return {edges_.data() + static_cast<std::ptrdiff_t>(column) * (rows_ + 1) + first_row(part),
            static_cast<std::size_t>(rows_of(part)) + 1};
  }

  // Bounds of x and y of these.
  [[nodiscard]] const Box& tangents(int column, int part) const {
    fill();
    return tangents_[static_cast<std::size_t>(column * parts_ + part)];
  }

 private:
  void fill() const {
    std::call_once(filled_, [&] {
      edges_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_ + 1));
      for (int column = 0; column < columns_; ++column) {
        for (int row = 0; row <= rows_; ++row) {
          edges_.push_back(camera_.sight({row - 0.5, column + 0.0}));
        }
      }
      for (int column = 0; column < columns_; ++column) {
        for (int part = 0; part < parts_; ++part) {
          tangents_.push_back(
              tangents_of({edges_.data() + static_cast<std::ptrdiff_t>(column) * (rows_ + 1) + first_row(part),
                           static_cast<std::size_t>(rows_of(part)) + 1}));
        }
      }
    });
  }

  Pinhole camera_;
  int rows_, columns_, parts_;
  mutable std::once_flag filled_;
  mutable std::vector<Point3> edges_;  // column by column
  mutable std::vector<Box> tangents_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_BLOCKS_H
