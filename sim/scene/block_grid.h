// The blocks of pixels into which an image is divided, with the margin around it that the lens gathers light from.
#ifndef SELFPROJ_SIM_SCENE_BLOCK_GRID_H
#define SELFPROJ_SIM_SCENE_BLOCK_GRID_H

#include <array>
#include <cstddef>

#include "host/rig/rig.h"
#include "sim/scene/lens_kernel.h"
#include "sim/scene/pinhole.h"

namespace selfproj {

inline constexpr int kBlockPixels = 4;                              // along a side of a block
inline constexpr int kBlockSide = kBlockPixels * kSubPixels;        // sub-pixels along a side of a block
inline constexpr int kBlockSamples = kBlockSide * kBlockSide;       // sub-pixels in a block
using BlockValues = std::array<float, std::size_t{kBlockSamples}>;  // grey values of a block's sub-pixels, row by row

// Blocks, and nodes at their corners, in the middles of their sides and in their middles. Node (2 down, 2 across) is
// the upper left corner of block (down, across).
class BlockGrid {
 public:
  BlockGrid(const RigCamera& camera, int margin)
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

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BLOCK_GRID_H
