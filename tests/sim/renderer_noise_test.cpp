// Compares noise, rounding and repeatability of rendered images with statistics.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "host/light_section/pattern.h"
#include "host/rig/rig.h"
#include "sim/scene/parallel.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"
#include "tests/sim/level_scene.h"

namespace selfproj {
namespace {

using test::Frame;
using test::ideal;
using test::LevelScene;
using test::line_at;

struct Statistics {
  double mean;
  double variance;
};

// Statistics of the difference between noisy frames and the ideal one.
Statistics noise_of(const Rig& rig, const Scene& scene, const FloatImage& pattern, const RenderOptions& options) {
  const Frame ideal_frame(rig, Renderer(rig, scene, pattern, ideal()), 0);
  const Renderer renderer(rig, scene, pattern, options);
  double sum = 0;
  double squares = 0;
  double count = 0;
  for (int i = 0; i < 2; ++i) {
    const Frame frame(rig, renderer, i);
    for (std::size_t k = 0; k < frame.pixels.size(); ++k) {
      const double difference = static_cast<double>(frame.pixels[k]) - static_cast<double>(ideal_frame.pixels[k]);
      sum += difference;
      squares += difference * difference;
      count += 1;
    }
  }
  return {sum / count, squares / count - sum / count * sum / count};
}

TEST(RendererNoise, NoiseHasTheRigsMeanAndVariance) {
  Rig rig = load_rig("light-section");
  rig.imaging.ambient = 60;
  rig.imaging.read_noise = 1.5;
  const LevelScene scene;
  const FloatImage none(512, 512);
  const double shot = (60 - 2) / rig.imaging.electrons_per_grey;
  struct Case {
    bool shot, read, quantization;
    double variance;
  };
  for (const Case& c : {Case{true, false, false, shot}, Case{false, true, false, 2.25},
                        Case{true, true, false, shot + 2.25}, Case{true, true, true, shot + 2.25 + 1.0 / 12}}) {
    RenderOptions options = ideal();
    options.shot_noise = c.shot;
    options.read_noise = c.read;
    options.quantization = c.quantization;
    const Statistics found = noise_of(rig, scene, none, options);
    // of 98,304 pixels: five standard deviations
    EXPECT_NEAR(found.mean, 0, 5 * std::sqrt(c.variance / 98304));
    EXPECT_NEAR(found.variance / c.variance, 1, 5 * std::sqrt(2.0 / 98304));
  }
  // more light, more shot noise
  RenderOptions options = ideal();
  options.shot_noise = true;
  const Statistics lit = noise_of(rig, scene, FloatImage(512, 512, 1), options);
  const Frame frame(rig, Renderer(rig, scene, FloatImage(512, 512, 1), ideal()), 0);
  const double mean =
      std::accumulate(frame.pixels.begin(), frame.pixels.end(), 0.0) / static_cast<double>(frame.pixels.size());
  EXPECT_NEAR(lit.variance / ((mean - 2) / rig.imaging.electrons_per_grey), 1, 0.03);
}

TEST(RendererNoise, EightBitsAreRoundedAndBounded) {
  Rig rig = load_rig("light-section");
  rig.imaging.white = 255;
  rig.imaging.ambient = 250;
  rig.imaging.read_noise = 20;
  const LevelScene scene;
  const Renderer renderer(rig, scene, FloatImage(512, 512, 1), {});
  std::vector<std::uint8_t> bytes(96 * 512);
  renderer.render(3, bytes);
  const Frame frame(rig, renderer, 3);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    ASSERT_EQ(static_cast<float>(bytes[i]), frame.pixels[i]);
  }
  EXPECT_EQ(*std::max_element(bytes.begin(), bytes.end()), 255);
  RenderOptions free;
  free.quantization = false;
  const Frame unbounded(rig, Renderer(rig, scene, FloatImage(512, 512, 1), free), 3);
  EXPECT_GT(*std::max_element(unbounded.pixels.begin(), unbounded.pixels.end()), 260.0F);
  EXPECT_NE(unbounded.pixels[0], std::nearbyint(unbounded.pixels[0]));
}

TEST(RendererNoise, ImagesDependOnSeedAndFrameAloneNotOnOrderOrThreads) {
  Rig rig = load_rig("light-section");
  const auto scene = make_scene("stairs-marked", rig);
  const FloatImage line = draw_straight_line(rig, line_at(rig, 0, rig.plane_z_mm - 39));
  const Renderer renderer(rig, *scene, line);
  constexpr int kCount = 6;
  constexpr int kFirst = 640;
  std::vector<std::vector<std::uint8_t>> alone(kCount, std::vector<std::uint8_t>(96 * 512));
  std::vector<std::vector<std::uint8_t>> together = alone;
  for (int i = kCount - 1; i >= 0; --i) {
    renderer.render(kFirst + i, alone[static_cast<std::size_t>(i)]);
  }
  parallel_for(kCount, 3, [&](int i) { renderer.render(kFirst + i, together[static_cast<std::size_t>(i)]); });
  EXPECT_EQ(alone, together);
  EXPECT_NE(alone[0], alone[1]);
  rig.imaging.seed = 2;
  std::vector<std::uint8_t> other(96 * 512);
  Renderer(rig, *scene, line).render(kFirst, other);
  EXPECT_NE(other, alone[0]);
}

}  // namespace
}  // namespace selfproj
