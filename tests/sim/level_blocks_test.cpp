// What is kept of level blocks, and what is known about level pixels, equals what tracing each ray gives.
#include "sim/scene/level_blocks.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "host/light_section/pattern.h"
#include "host/rig/rig.h"
#include "sim/scene/planted_part.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene_list.h"
#include "tests/sim/level_scene.h"

namespace selfproj {
namespace {

TEST(LevelBlocks, KeepsAFewHeightsOfEachBlock) {
  LevelBlocks blocks(2);
  EXPECT_EQ(blocks.find(0, 1), nullptr);
  blocks.keep(0, {1, {}});
  blocks.keep(0, {2, std::vector<float>(kBlockSamples, 7)});
  blocks.keep(0, {2, {}});  // is kept already
  ASSERT_NE(blocks.find(0, 1), nullptr);
  EXPECT_TRUE(blocks.find(0, 1)->dark());
  ASSERT_NE(blocks.find(0, 2), nullptr);
  EXPECT_EQ(blocks.find(0, 2)->values, std::vector<float>(kBlockSamples, 7));
  EXPECT_EQ(blocks.find(1, 1), nullptr);
  for (std::size_t i = 0; i < LevelBlocks::kHeights; ++i) {
    blocks.keep(0, {3 + static_cast<double>(i), {}});
  }
  EXPECT_NE(blocks.find(0, 4), nullptr);
  EXPECT_EQ(blocks.find(0, 5), nullptr);
}

// The same surface as another scene, but not known to have exact levels.
class Traced final : public Scene {
 public:
  explicit Traced(const Scene& scene) : scene_(scene) {}
  [[nodiscard]] int frames() const override { return scene_.frames(); }
  [[nodiscard]] double height(double x, double y, double t) const override { return scene_.height(x, y, t); }
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override {
    return scene_.range(box, t0, t1);
  }
  [[nodiscard]] bool has_exact_levels() const override { return false; }
  [[nodiscard]] double speed() const override { return scene_.speed(); }

 private:
  const Scene& scene_;
};

// A renderer that has rendered other frames, one that has not, and one that traces all rays of blocks that are not
// level make the same images to the last bit.
TEST(LevelBlocks, ImagesAreThoseOfRaysThatAreTraced) {
  const Rig rig = load_rig("light-section");
  const auto stairs = make_scene("stairs-marked", rig);
  const PlantedPart part(rig, {0.1, 0.3, 0.7}, {{1, 8, 10, 4, -0.5}, {0, 8, -10, 2, 0.3}});
  RenderOptions options;
  options.quantization = false;
  for (const Scene* scene : {static_cast<const Scene*>(stairs.get()), static_cast<const Scene*>(&part)}) {
    for (const RealRig& real : {RealRig(rig), hidden_rig(rig, 1)}) {
      const FloatImage line = draw_straight_line(rig, test::line_at(rig, 1, rig.plane_z_mm - 20));
      const Traced slow(*scene);
      const Renderer renderer(real, *scene, line, options);
      const Renderer traced(real, slow, line, options);
      for (int i = 1; i < 6; ++i) {
        const int frame = scene->frames() * i / 6;
        std::vector<float> a(rig.camera.pixels());
        std::vector<float> b(rig.camera.pixels());
        std::vector<float> c(rig.camera.pixels());
        renderer.render(frame, std::span(a));
        traced.render(frame, std::span(b));
        Renderer(real, *scene, line, options).render(frame, std::span(c));
        EXPECT_EQ(a, b) << frame;
        EXPECT_EQ(a, c) << frame;
      }
    }
  }
}

}  // namespace
}  // namespace selfproj
