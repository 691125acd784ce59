// Without a disturbance of the world, images are those of before there was any, byte for byte. The sums were made of
// the PNG files of the program of that time.
#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/light_section/pattern.h"
#include "host/rig/rig.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/pattern_set.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene_list.h"

namespace selfproj {
namespace {

// FNV-1a.
std::uint64_t sum_of(const std::vector<std::uint8_t>& pixels) {
  std::uint64_t sum = 0xcbf29ce484222325U;
  for (const std::uint8_t pixel : pixels) {
    sum = (sum ^ pixel) * 0x100000001b3U;
  }
  return sum;
}

FloatImage line_on_plane(const Rig& rig) {
  return draw_straight_line(rig, Pinhole::of_projector(rig.projector).project({0, 0, rig.plane_z_mm}).row);
}

std::uint64_t of_line(const RealRig& real, const std::string& scene_name, int frame, const RenderOptions& options) {
  const auto scene = make_scene(scene_name, real.rig);
  const Rig& rig = real.rig;
  std::vector<std::uint8_t> pixels(rig.camera.pixels());
  Renderer(real, *scene, line_on_plane(rig), options).render(frame - 1, std::span(pixels));
  return sum_of(pixels);
}

std::uint64_t of_pattern(const std::string& scene_name, int frame, int pattern) {
  const Rig rig = load_rig("scanner");
  const auto scene = make_scene(scene_name, rig);
  const std::vector<Image> patterns = gray_patterns(rig.projector, 8);
  std::vector<std::uint8_t> pixels(rig.camera.pixels());
  PatternRenderer(rig, *scene)
      .render(frame - 1, project_image(rig, patterns[static_cast<std::size_t>(pattern)]), std::span(pixels));
  return sum_of(pixels);
}

TEST(ImagesOfBefore, OfALine) {
  const Rig rig = load_rig("light-section");
  EXPECT_EQ(of_line(rig, "stairs-marked", 700, {}), 0xc91e686512317edcU);
  EXPECT_EQ(of_line(rig, "stairs-marked", 701, {}), 0x71de9c1ca9382ed4U);
  EXPECT_EQ(of_line(rig, "mountain", 300, {}), 0x66fa39af3e067559U);
  RenderOptions falling;
  falling.falloff = true;
  EXPECT_EQ(of_line(hidden_rig(rig, 3), "mountain", 300, falling), 0x73faae068e6eef81U);
}

TEST(ImagesOfBefore, OfWholePatterns) {
  EXPECT_EQ(of_pattern("desk", 1, 0), 0x816f27fe4bf7fff4U);
  EXPECT_EQ(of_pattern("cuboids-marked", 2, 1), 0x2448fd90bbd0877eU);
  EXPECT_EQ(of_pattern("fist", 101, 0), 0xa54b773e0604e7e2U);
}

// A world in which nothing is on is no world at all, and one with a name on changes the image.
TEST(ImagesOfBefore, OnlyWithoutDisturbances) {
  const Rig rig = load_rig("light-section");
  const WorldFile file = load_world(kBuiltInWorld);
  RenderOptions options;
  options.world = world_of(file, {});
  EXPECT_EQ(of_line(rig, "stairs-marked", 700, options), 0xc91e686512317edcU);
  const auto scene = make_scene("stairs-marked", rig);
  const auto image_of = [&](const std::vector<std::string>& names) {
    RenderOptions exact = options;
    exact.quantization = false;
    exact.world = world_of(file, names);
    std::vector<float> pixels(rig.camera.pixels());  // of the part's front edge, on which a straight line falls
    Renderer(rig, *scene, line_on_plane(rig), exact).render(54, std::span(pixels));
    return pixels;
  };
  const std::vector<float> before = image_of({});
  for (const WorldSwitch& entry : world_switches()) {
    EXPECT_NE(image_of({entry.name}), before) << entry.name;
  }
}

}  // namespace
}  // namespace selfproj
