// What is known about a block of pixels as a whole holds for each of its rays.
#include "sim/scene/block_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/light_section/pattern.h"
#include "host/rig/rig.h"
#include "sim/scene/block_grid.h"
#include "sim/scene/even_numbers.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/planted_part.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/ray.h"
#include "sim/scene/real_rig.h"
#include "tests/sim/level_scene.h"

namespace selfproj {
namespace {

// No point of a block gets light at heights at which may_be_lit is false; and it is true for hardly any dark block.
TEST(BlockViews, WhatMayNotBeLitIsDark) {
  const Rig rig = load_rig("light-section");
  EvenNumbers numbers(1);
  for (const RealRig& real : {RealRig(rig), hidden_rig(rig, 3)}) {
    const BlockGrid grid(rig.camera, 3);
    BlockViews views(real, grid, {0, 40});
    const ProjectedLight light(draw_straight_line(rig, test::line_at(rig, 1, rig.plane_z_mm - 10)), 0.7);
    EXPECT_TRUE(views.may_be_lit(0, {0, 1})) << "before a light is set, nothing is known";
    views.set_light(light);
    int not_lit = 0;
    int dark = 0;
    for (int i = 0; i < 50000; ++i) {
      const int down = static_cast<int>(grid.down() * numbers.next());
      const int across = static_cast<int>(grid.across() * numbers.next());
      const std::size_t block = grid.block(down, across);
      const double low = 40 * numbers.next();
      const HeightRange heights{low, std::min(40.0, low + (i % 2 == 0 ? 0 : 5 * numbers.next()))};
      dark += views.is_dark(block, heights, light) ? 1 : 0;
      if (!views.may_be_lit(block, heights)) {
        ++not_lit;
        const PixelPoint pixel = grid.sample_pixel(down, across, static_cast<int>(kBlockSide * numbers.next()),
                                                   static_cast<int>(kBlockSide * numbers.next()));
        const double height = heights.low + (heights.high - heights.low) * numbers.next();
        EXPECT_EQ(light.at(real.projector.project(real.camera.point_at(pixel, rig.plane_z_mm - height))), 0);
      }
    }
    EXPECT_GT(not_lit, 0.9 * dark);
    EXPECT_LT(dark, 45000) << "some are lit";
    EXPECT_TRUE(views.may_be_lit(0, {-1, 0})) << "nothing is known beyond the heights";
    EXPECT_TRUE(views.may_be_lit(0, {40, 41}));
  }
}

// The shadow on a level block is that on each of its points, found ray by ray.
TEST(BlockViews, ShadowOfABlockIsThatOfItsPoints) {
  const Rig rig = load_rig("light-section");
  const RealRig real = hidden_rig(rig, 1);
  const PlantedPart part(rig, {0.1, 0.3, 0.7}, {{1, 8, 10, 4, -0.5}});
  const LitSurface surface(real, part, false);
  const BlockGrid grid(rig.camera, 3);
  const BlockViews views(real, grid, {0, 21});
  EvenNumbers numbers(2);
  int none = 0;
  int all = 0;
  for (int i = 0; i < 20000; ++i) {
    const double t = 0.25 * part.frames() / rig.camera.frame_rate_hz * (1 + 2 * numbers.next());
    const HeightRange highest = surface.all_heights(t, t);
    const int down = static_cast<int>(grid.down() * numbers.next());
    const int across = static_cast<int>(grid.across() * numbers.next());
    const Box& tangents = views.tangents(grid.block(down, across));
    const HeightRange heights = surface.heights_between(tangents, t, t, highest);
    if (heights.high - heights.low > kHeightTolerance) {
      continue;
    }
    const LitSurface::Shadow shadow = surface.shadow_on_level(tangents, heights.low, t, t, highest.high);
    if (shadow == LitSurface::Shadow::some) {
      continue;
    }
    (shadow == LitSurface::Shadow::all ? all : none) += 1;
    for (int k = 0; k < 4; ++k) {
      const PixelPoint pixel = grid.sample_pixel(down, across, static_cast<int>(kBlockSide * numbers.next()),
                                                 static_cast<int>(kBlockSide * numbers.next()));
      const LitSurface::Hit hit = surface.hit(pixel, t, heights);
      EXPECT_EQ(surface.in_shadow(hit.point, surface.normal(hit, t), t, highest.high),
                shadow == LitSurface::Shadow::all);
    }
  }
  EXPECT_GT(none, 5000);
  EXPECT_GT(all, 500);
}

}  // namespace
}  // namespace selfproj
