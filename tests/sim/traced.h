// What a renderer knows of whole blocks and level pixels, compared with rays that are traced one by one.
#ifndef SELFPROJ_TESTS_SIM_TRACED_H
#define SELFPROJ_TESTS_SIM_TRACED_H

#include <gtest/gtest.h>

#include <span>
#include <vector>

#include "host/light_section/pattern.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/blocks.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/random.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "tests/sim/level_scene.h"

namespace selfproj::test {

// The same surface as another scene, but not known to have exact levels.
class Traced final : public sim::WrappedScene {
 public:
  using sim::WrappedScene::WrappedScene;
  [[nodiscard]] bool has_exact_levels() const override { return false; }
};

// A renderer that has rendered other frames, one that has not, and one that traces all rays of blocks that are not
// level make the same images to the last bit.
inline void expect_images_of_traced_rays(const rig::Rig& rig, const sim::Scene& scene) {
  sim::RenderOptions options;
  options.quantization = false;
  for (const sim::PerturbedRig& actual : {sim::PerturbedRig(rig), sim::hidden_rig(rig, 1)}) {
    const images::FloatImage line = light_section::draw_straight_line(rig, line_at(rig, 1, rig.plane_z_mm - 20));
    const Traced slow(scene);
    const sim::LineRenderer renderer(actual, scene, line, options);
    const sim::LineRenderer traced(actual, slow, line, options);
    for (int i = 1; i < 6; ++i) {
      const int frame = scene.frames() * i / 6;
      std::vector<float> a(rig.camera.pixels());
      std::vector<float> b(rig.camera.pixels());
      std::vector<float> c(rig.camera.pixels());
      renderer.render(frame, std::span(a));
      traced.render(frame, std::span(b));
      sim::LineRenderer(actual, scene, line, options).render(frame, std::span(c));
      EXPECT_EQ(a, b) << frame;
      EXPECT_EQ(a, c) << frame;
    }
  }
}

// The shadow on a level block is that on each of its points, found ray by ray.
inline void expect_shadows_of_points(const sim::PerturbedRig& actual, const sim::Scene& scene,
                                     sim::HeightRange heights_of_all, int blocks) {
  const rig::Rig& rig = actual.rig;
  const sim::LitSurface surface(actual, scene, false);
  const sim::BlockGrid grid(rig.camera, 3);
  const sim::BlockViews views(actual, grid, heights_of_all);
  sim::EvenNumbers numbers(2);
  int none = 0;
  int all = 0;
  for (int i = 0; i < blocks; ++i) {
    const double t = 0.25 * scene.frames() / rig.camera.frame_rate_hz * (1 + 2 * numbers.next());
    const sim::HeightRange highest = surface.all_heights(t, t);
    const int down = static_cast<int>(grid.down() * numbers.next());
    const int across = static_cast<int>(grid.across() * numbers.next());
    const sim::Box& tangents = views.tangents(grid.block(down, across));
    const sim::HeightRange heights = surface.heights_between(tangents, t, t, highest);
    if (heights.high - heights.low > sim::kHeightTolerance) {
      continue;
    }
    const sim::LitSurface::Shadow shadow = surface.shadow_on_level(tangents, heights.low, t, t, highest.high);
    if (shadow == sim::LitSurface::Shadow::some) {
      continue;
    }
    (shadow == sim::LitSurface::Shadow::all ? all : none) += 1;
    for (int k = 0; k < 4; ++k) {
      const sim::PixelPoint pixel = grid.sample_pixel(down, across, static_cast<int>(sim::kBlockSide * numbers.next()),
                                                      static_cast<int>(sim::kBlockSide * numbers.next()));
      const sim::LitSurface::Hit hit = surface.hit(pixel, t, heights);
      EXPECT_EQ(surface.in_shadow(hit.point, surface.normal(hit, t), t, highest.high),
                shadow == sim::LitSurface::Shadow::all);
    }
  }
  EXPECT_GT(none, 5000);
  EXPECT_GT(all, 500);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SIM_TRACED_H
