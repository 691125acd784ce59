// Sub-pixels folded with the lens, everywhere and in parts of an image.
#include "sim/scene/blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "host/light_section/pattern.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/optics.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/random.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scenes.h"
#include "tests/sim/level_scene.h"
#include "tests/sim/traced.h"

namespace selfproj::test {
namespace {

constexpr double kBlur = 0.7;

rig::RigCamera small_camera() {
  rig::RigCamera camera = rig::load_rig("light-section").camera;
  camera.rows = 41;
  camera.columns = 62;
  return camera;
}

// Grey values of all sub-pixels, block by block.
std::vector<sim::BlockValues> random_blocks(const sim::BlockGrid& grid) {
  sim::EvenNumbers numbers(3);
  std::vector<sim::BlockValues> blocks(grid.blocks());
  for (sim::BlockValues& block : blocks) {
    std::generate(block.begin(), block.end(), [&] { return static_cast<float>(100 * numbers.next()); });
  }
  return blocks;
}

TEST(BlockFold, IsTheSumOfWeightedSubPixels) {
  const rig::RigCamera camera = small_camera();
  const sim::BlockGrid grid(camera, sim::lens_margin(kBlur));
  const std::vector<float> kernel = sim::lens_kernel(kBlur);
  const std::vector<sim::BlockValues> blocks = random_blocks(grid);
  const auto sub_pixel = [&](int r, int c) {
    return static_cast<double>(blocks[grid.block(r / sim::kBlockSide, c / sim::kBlockSide)][static_cast<std::size_t>(
        r % sim::kBlockSide * sim::kBlockSide + c % sim::kBlockSide)]);
  };
  const sim::BlockFold fold(camera, kBlur);
  std::vector<float> image(camera.pixels());
  const std::vector<sim::IndexSpan> all(static_cast<std::size_t>(camera.rows), {0, camera.columns - 1});
  fold.fold(
      all, [&](int down, int across, sim::BlockValues& values) { values = blocks[grid.block(down, across)]; }, image);
  const int taps = static_cast<int>(kernel.size());
  for (int r = 0; r < camera.rows; ++r) {
    for (int c = 0; c < camera.columns; ++c) {
      double sum = 0;
      for (int i = 0; i < taps; ++i) {
        for (int j = 0; j < taps; ++j) {
          sum += static_cast<double>(kernel[static_cast<std::size_t>(i)]) *
                 static_cast<double>(kernel[static_cast<std::size_t>(j)]) *
                 sub_pixel(r * sim::kSubPixels + i, c * sim::kSubPixels + j);
        }
      }
      EXPECT_NEAR(static_cast<double>(image[static_cast<std::size_t>(r * camera.columns + c)]), sum, 1e-3);
    }
  }
}

// Pixels near some blocks are the same to the last bit if only these are made; the others are left, and need none of
// these blocks.
TEST(BlockFold, PartsAreThoseOfTheWhole) {
  const rig::RigCamera camera = small_camera();
  const sim::BlockGrid grid(camera, sim::lens_margin(kBlur));
  std::vector<sim::BlockValues> blocks = random_blocks(grid);
  const sim::BlockFold fold(camera, kBlur);
  const auto values_of = [&](int down, int across, sim::BlockValues& values) {
    values = blocks[grid.block(down, across)];
  };
  const std::vector<sim::IndexSpan> everywhere(static_cast<std::size_t>(grid.down()), {0, grid.across() - 1});
  std::vector<float> before(camera.pixels());
  fold.fold(fold.pixels_of(everywhere), values_of, before);

  std::vector<sim::IndexSpan> lit(static_cast<std::size_t>(grid.down()));
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
      [&](int down, int across, sim::BlockValues& values) {
        ++made;
        values_of(down, across, values);
      },
      part);
  EXPECT_NE(whole, before);
  EXPECT_EQ(part, whole);
  EXPECT_LT(made, grid.blocks() / 2);

  part = before;
  fold.fold(fold.pixels_of(std::vector<sim::IndexSpan>(static_cast<std::size_t>(grid.down()))), values_of, part);
  EXPECT_EQ(part, before) << "nothing is lit";
}

// What is known about a block of pixels as a whole holds for each of its rays.

// No point of a block gets light at heights at which may_be_lit is false; and it is true for hardly any dark block.
TEST(BlockViews, WhatMayNotBeLitIsDark) {
  const rig::Rig rig = rig::load_rig("light-section");
  sim::EvenNumbers numbers(1);
  for (const sim::PerturbedRig& actual : {sim::PerturbedRig(rig), sim::hidden_rig(rig, 3)}) {
    const sim::BlockGrid grid(rig.camera, 3);
    sim::BlockViews views(actual, grid, {0, 40});
    const sim::ProjectedLight light(light_section::draw_straight_line(rig, line_at(rig, 1, rig.plane_z_mm - 10)), 0.7);
    EXPECT_TRUE(views.may_be_lit(0, {0, 1})) << "before a light is set, nothing is known";
    views.set_light(light);
    int not_lit = 0;
    int dark = 0;
    for (int i = 0; i < 50000; ++i) {
      const int down = static_cast<int>(grid.down() * numbers.next());
      const int across = static_cast<int>(grid.across() * numbers.next());
      const std::size_t block = grid.block(down, across);
      const double low = 40 * numbers.next();
      const sim::HeightRange heights{low, std::min(40.0, low + (i % 2 == 0 ? 0 : 5 * numbers.next()))};
      dark += views.is_dark(block, heights, light) ? 1 : 0;
      if (!views.may_be_lit(block, heights)) {
        ++not_lit;
        const sim::PixelPoint pixel =
            grid.sample_pixel(down, across, static_cast<int>(sim::kBlockSide * numbers.next()),
                              static_cast<int>(sim::kBlockSide * numbers.next()));
        const double height = heights.low + (heights.high - heights.low) * numbers.next();
        EXPECT_EQ(light.at(actual.projector.project(actual.camera.point_at(pixel, rig.plane_z_mm - height))), 0);
      }
    }
    EXPECT_GT(not_lit, 0.9 * dark);
    EXPECT_LT(dark, 45000) << "some are lit";
    EXPECT_TRUE(views.may_be_lit(0, {-1, 0})) << "nothing is known beyond the heights";
    EXPECT_TRUE(views.may_be_lit(0, {40, 41}));
  }
}

TEST(BlockViews, ShadowOfABlockIsThatOfItsPoints) {
  const rig::Rig rig = rig::load_rig("light-section");
  expect_shadows_of_points(sim::hidden_rig(rig, 1), *sim::make_scene("stairs", rig), {0, 39}, 80000);
}

// What is kept of level blocks, and what is known about level pixels, equals what tracing each ray gives.

TEST(LevelBlocks, KeepsAFewHeightsOfEachBlock) {
  sim::LevelBlocks blocks(2);
  EXPECT_EQ(blocks.find(0, 1), nullptr);
  blocks.keep(0, {1, {}});
  blocks.keep(0, {2, std::vector<float>(sim::kBlockSamples, 7)});
  blocks.keep(0, {2, {}});  // is kept already
  ASSERT_NE(blocks.find(0, 1), nullptr);
  EXPECT_TRUE(blocks.find(0, 1)->dark());
  ASSERT_NE(blocks.find(0, 2), nullptr);
  EXPECT_EQ(blocks.find(0, 2)->values, std::vector<float>(sim::kBlockSamples, 7));
  EXPECT_EQ(blocks.find(1, 1), nullptr);
  for (std::size_t i = 0; i < sim::LevelBlocks::kHeights; ++i) {
    blocks.keep(0, {3 + static_cast<double>(i), {}});
  }
  EXPECT_NE(blocks.find(0, 4), nullptr);
  EXPECT_EQ(blocks.find(0, 5), nullptr);
}

TEST(LevelBlocks, ImagesAreThoseOfRaysThatAreTraced) {
  const rig::Rig rig = rig::load_rig("light-section");
  expect_images_of_traced_rays(rig, *sim::make_scene("stairs-marked", rig));
}

// The sights and bounds that are kept for the columns of a camera are those of its pixels' edges.

// Also where the last part is shorter than the others, and where there is only one part.
TEST(ColumnViews, EdgesAreThoseOfThePixels) {
  for (const int rows : {96, 39, 5}) {
    rig::Rig rig = rig::load_rig("light-section");
    rig.camera.rows = rows;
    rig.camera.columns = 40;
    const sim::Pinhole camera = sim::hidden_rig(rig, 2).camera;
    const sim::ColumnViews views(camera, rig.camera);
    int next = 0;
    for (int part = 0; part < views.parts(); ++part) {
      ASSERT_EQ(views.first_row(part), next) << "parts leave no row out";
      next += views.rows_of(part);
    }
    EXPECT_EQ(next, rows);
    for (int column = 0; column < rig.camera.columns; ++column) {
      for (int part = 0; part < views.parts(); ++part) {
        const std::span<const sim::Point3> edges = views.edges(column, part);
        ASSERT_EQ(edges.size(), static_cast<std::size_t>(views.rows_of(part)) + 1);
        double row = views.first_row(part) - 0.5;
        for (const sim::Point3 edge : edges) {
          const sim::Point3 sight = camera.sight({row, static_cast<double>(column)});
          EXPECT_EQ(edge.x, sight.x);
          EXPECT_EQ(edge.y, sight.y);
          EXPECT_EQ(edge.z, sight.z);
          row += 1;
        }
      }
    }
  }
}

TEST(ColumnViews, TangentsAreTheTightestBoundsOfTheEdges) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.columns = 40;
  const sim::ColumnViews views(sim::hidden_rig(rig, 3).camera, rig.camera);
  for (int column = 0; column < rig.camera.columns; ++column) {
    for (int part = 0; part < views.parts(); ++part) {
      const std::span<const sim::Point3> edges = views.edges(column, part);
      const auto [left, right] =
          std::minmax_element(edges.begin(), edges.end(), [](sim::Point3 a, sim::Point3 b) { return a.x < b.x; });
      const auto [low, high] =
          std::minmax_element(edges.begin(), edges.end(), [](sim::Point3 a, sim::Point3 b) { return a.y < b.y; });
      const sim::Box& tangents = views.tangents(column, part);
      EXPECT_EQ(tangents.x0, left->x);
      EXPECT_EQ(tangents.x1, right->x);
      EXPECT_EQ(tangents.y0, low->y);
      EXPECT_EQ(tangents.y1, high->y);
    }
  }
}

}  // namespace
}  // namespace selfproj::test
