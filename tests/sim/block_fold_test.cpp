// Sub-pixels folded with the lens, everywhere and in parts of an image.
#include "sim/scene/block_fold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/block_grid.h"
#include "sim/scene/even_numbers.h"
#include "sim/scene/lens_kernel.h"

namespace selfproj {
namespace {

constexpr double kBlur = 0.7;

RigCamera small_camera() {
  RigCamera camera = load_rig("light-section").camera;
  camera.rows = 41;
  camera.columns = 62;
  return camera;
}

// Grey values of all sub-pixels, block by block.
std::vector<BlockValues> random_blocks(const BlockGrid& grid) {
  EvenNumbers numbers(3);
  std::vector<BlockValues> blocks(grid.blocks());
  for (BlockValues& block : blocks) {
    std::generate(block.begin(), block.end(), [&] { return static_cast<float>(100 * numbers.next()); });
  }
  return blocks;
}

TEST(BlockFold, IsTheSumOfWeightedSubPixels) {
  const RigCamera camera = small_camera();
  const BlockGrid grid(camera, lens_margin(kBlur));
  const std::vector<float> kernel = lens_kernel(kBlur);
  const std::vector<BlockValues> blocks = random_blocks(grid);
  const auto sub_pixel = [&](int r, int c) {
    return static_cast<double>(blocks[grid.block(r / kBlockSide, c / kBlockSide)]
                                     [static_cast<std::size_t>(r % kBlockSide * kBlockSide + c % kBlockSide)]);
  };
  const BlockFold fold(camera, grid, kernel);
  std::vector<float> image(camera.pixels());
  const std::vector<IndexSpan> all(static_cast<std::size_t>(camera.rows), {0, camera.columns - 1});
  fold.fold(
      all, [&](int down, int across, BlockValues& values) { values = blocks[grid.block(down, across)]; }, image);
  const int taps = static_cast<int>(kernel.size());
  for (int r = 0; r < camera.rows; ++r) {
    for (int c = 0; c < camera.columns; ++c) {
      double sum = 0;
      for (int i = 0; i < taps; ++i) {
        for (int j = 0; j < taps; ++j) {
          sum += static_cast<double>(kernel[static_cast<std::size_t>(i)]) *
                 static_cast<double>(kernel[static_cast<std::size_t>(j)]) *
                 sub_pixel(r * kSubPixels + i, c * kSubPixels + j);
        }
      }
      EXPECT_NEAR(static_cast<double>(image[static_cast<std::size_t>(r * camera.columns + c)]), sum, 1e-3);
    }
  }
}

// Pixels near some blocks are the same to the last bit if only these are made; the others are left, and need none of
// these blocks.
TEST(BlockFold, PartsAreThoseOfTheWhole) {
  const RigCamera camera = small_camera();
  const BlockGrid grid(camera, lens_margin(kBlur));
  std::vector<BlockValues> blocks = random_blocks(grid);
  const BlockFold fold(camera, grid, lens_kernel(kBlur));
  const auto values_of = [&](int down, int across, BlockValues& values) { values = blocks[grid.block(down, across)]; };
  const std::vector<IndexSpan> everywhere(static_cast<std::size_t>(grid.down()), {0, grid.across() - 1});
  std::vector<float> before(camera.pixels());
  fold.fold(fold.pixels_of(everywhere), values_of, before);

  std::vector<IndexSpan> lit(static_cast<std::size_t>(grid.down()));
  lit[3] = {5, 7};
  lit[4] = {6, 9};
  blocks[grid.block(3, 5)].fill(1000);
  blocks[grid.block(4, 9)].fill(1000);
  std::vector<float> whole(camera.pixels());
  fold.fold(fold.pixels_of(everywhere), values_of, whole);
  std::vector<float> part = before;
  std::size_t made = 0;
  fold.fold(
      fold.pixels_of(lit),
      [&](int down, int across, BlockValues& values) {
        ++made;
        values_of(down, across, values);
      },
      part);
  EXPECT_NE(whole, before);
  EXPECT_EQ(part, whole);
  EXPECT_LT(made, grid.blocks() / 2);

  part = before;
  fold.fold(fold.pixels_of(std::vector<IndexSpan>(static_cast<std::size_t>(grid.down()))), values_of, part);
  EXPECT_EQ(part, before) << "nothing is lit";
}

}  // namespace
}  // namespace selfproj
