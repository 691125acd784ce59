// Faults of sensor, light and machine against closed forms and statistics.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "host/files/user_error.h"
#include "host/light_section/pattern.h"
#include "host/rig/rig.h"
#include "sim/scene/defect_pixels.h"
#include "sim/scene/fixed_pattern.h"
#include "sim/scene/flicker.h"
#include "sim/scene/jitter.h"
#include "sim/scene/renderer.h"
#include "sim/scene/row_noise.h"
#include "sim/scene/saturation.h"
#include "sim/scene/second_line.h"
#include "sim/scene/vibration.h"
#include "sim/scene/world.h"
#include "tests/sim/level_scene.h"

namespace selfproj {
namespace {

using test::Frame;
using test::ideal;
using test::LevelScene;

struct Moments2 {
  double mean = 0;
  double deviation = 0;
};

Moments2 moments_of(std::span<const float> values) {
  double sum = 0;
  double squares = 0;
  for (const float value : values) {
    sum += static_cast<double>(value);
    squares += static_cast<double>(value) * static_cast<double>(value);
  }
  const auto n = static_cast<double>(values.size());
  return {sum / n, std::sqrt(squares / n - sum / n * sum / n)};
}

// EMVA 1288: the spatial standard deviation in the dark is the DSNU, and that of the light over its mean the PRNU.
TEST(FixedPattern, IsThatOfEmva1288) {
  constexpr std::size_t kPixels = 200'000;
  const FixedPatternMap map({.dsnu_electrons = 40, .prnu = 0.02}, 80, kPixels, 3);
  std::vector<float> dark(kPixels, 2.0F);
  std::vector<float> lit(kPixels, 102.0F);
  map.add_gains(2, dark);
  map.add_gains(2, lit);
  EXPECT_NEAR(moments_of(dark).deviation, 0, 1e-6);
  EXPECT_NEAR(moments_of(lit).mean, 102, 5 * 2 / std::sqrt(kPixels));
  EXPECT_NEAR(moments_of(lit).deviation / 100, 0.02, 0.0002);
  map.add_offsets(dark);
  EXPECT_NEAR(moments_of(dark).deviation, 0.5, 0.005);
  const std::vector<float> once = dark;
  std::fill(dark.begin(), dark.end(), 2.0F);
  map.add_offsets(dark);
  EXPECT_EQ(dark, once) << "the pattern is fixed";
}

// The number of defects has the mean and the deviation of a binomial distribution.
TEST(DefectPixels, AreAsManyAsTheirShare) {
  constexpr double kPixels = 96 * 512;
  double hot = 0;
  double squares = 0;
  constexpr int kCameras = 200;
  for (int camera = 0; camera < kCameras; ++camera) {
    const DefectMap map({.hot = 1e-3, .dead = 5e-4, .least_hot_grey = 100}, kPixels,
                        static_cast<std::uint64_t>(camera));
    hot += static_cast<double>(map.hot());
    squares += std::pow(static_cast<double>(map.hot()) - 1e-3 * kPixels, 2);
    std::vector<float> image(kPixels, 8.0F);
    map.apply(2, image);
    EXPECT_EQ(std::count(image.begin(), image.end(), 2.0F), static_cast<std::ptrdiff_t>(map.dead()));
    EXPECT_EQ(std::count_if(image.begin(), image.end(), [](float v) { return v >= 108 && v <= 263; }),
              static_cast<std::ptrdiff_t>(map.hot()));
  }
  EXPECT_NEAR(hot / kCameras, 1e-3 * kPixels, 5 * std::sqrt(1e-3 * kPixels / kCameras));
  EXPECT_NEAR(squares / kCameras / (1e-3 * kPixels), 1, 5 * std::sqrt(2.0 / kCameras));
}

TEST(RowNoise, IsOneOffsetARow) {
  constexpr int kRows = 20'000;
  std::vector<float> image(kRows * 4, 5.0F);
  add_row_noise({.grey = 0.3}, 1, 7, 4, image);
  std::vector<float> rows;
  for (std::size_t i = 0; i < image.size(); i += 4) {
    ASSERT_EQ(std::count(image.begin() + static_cast<std::ptrdiff_t>(i),
                         image.begin() + static_cast<std::ptrdiff_t>(i) + 4, image[i]),
              4);
    rows.push_back(image[i]);
  }
  EXPECT_NEAR(moments_of(rows).deviation, 0.3, 5 * 0.3 / std::sqrt(2.0 * kRows));
  EXPECT_NEAR(moments_of(rows).mean, 5, 5 * 0.3 / std::sqrt(kRows));
}

TEST(Saturation, IsLinearUpToTheWell) {
  std::vector<float> image{2, 12, 52, 150};
  saturate({.exposure = 3, .well_grey = 255}, 2, image);
  EXPECT_EQ(image, (std::vector<float>{2, 32, 152, 255}));
}

// The mean of a sine over an exposure is the sine times sinc.
TEST(Flicker, IsTheMeanOverTheExposure) {
  const Flicker lamp{.grey = 10, .modulation = 0.37, .hz = 100};
  for (const double exposure : {9e-5, 1e-3, 0.01}) {
    for (const double t : {0.0, 0.0013, 0.0071}) {
      double sum = 0;
      constexpr int kSteps = 20000;
      for (int i = 0; i < kSteps; ++i) {
        const double at = t + exposure * ((i + 0.5) / kSteps - 0.5);
        sum += 10 * (1 + 0.37 * std::sin(200 * std::numbers::pi * at)) / kSteps;
      }
      EXPECT_NEAR(flicker_grey(lamp, t, exposure), sum, 1e-6);
    }
  }
  EXPECT_NEAR(flicker_grey(lamp, 0.0025, 0.01), 10, 1e-9) << "a whole period shows no flicker";
}

// A camera that tips moves the image's centroid by as much.
TEST(Vibration, MovesTheImage) {
  constexpr int kRows = 40;
  constexpr int kColumns = 30;
  for (const double by : {0.3, -0.7, 1.4}) {
    std::vector<float> image(kRows * kColumns, 0.0F);
    for (int r = 0; r < kRows; ++r) {
      image[static_cast<std::size_t>(r * kColumns + 12)] =
          static_cast<float>(std::exp(-0.5 * std::pow((r - 17.2) / 1.5, 2)));
    }
    const auto centre = [&](bool down) {
      double sum = 0;
      double first = 0;
      for (int i = 0; i < kRows * kColumns; ++i) {
        const auto value = static_cast<double>(image[static_cast<std::size_t>(i)]);
        sum += value;
        first += value * (down ? i / kColumns : i % kColumns);
      }
      return first / sum;
    };
    const double row = centre(true);
    move_image(kRows, kColumns, {by, 2 * by}, image);
    EXPECT_NEAR(centre(true) - row, by, 1e-5);
    EXPECT_NEAR(centre(false) - 12, 2 * by, 1e-5);
  }
}

// A belt that swings by dz moves the line by what (3.4) says of the plane at that height.
TEST(Vibration, OfTheBeltIsHeight) {
  const Rig rig = load_rig("light-section");
  const LevelScene scene;
  const FloatImage line = draw_straight_line(rig, test::line_at(rig, 0, rig.plane_z_mm));
  RenderOptions options = ideal();
  options.camera_blur = true;
  options.world.vibration = Vibration{.belt_mm = 2, .belt_hz = 2500, .camera_px = 0, .camera_hz = 50};
  const Renderer renderer(rig, scene, line, options);
  for (const auto& [frame, height] :
       {std::pair(0, 0.0), std::pair(1, 2.0), std::pair(3, -2.0)}) {  // of 10,000 a second
    const double z = rig.plane_z_mm - height;
    const double tan = std::tan(std::atan2(rig.projector.x_mm, rig.plane_z_mm - rig.projector.z_mm));
    const double x = rig.projector.x_mm - (z - rig.projector.z_mm) * tan;
    EXPECT_NEAR(Frame(rig, renderer, frame).centroid(256, rig.imaging.ambient), test::row_of(rig, x / z), 0.02);
    EXPECT_EQ(renderer.true_height(frame, 0, 0), 0) << "the part does not grow";
  }
}

TEST(Jitter, HasItsDeviations) {
  std::vector<float> late;
  std::vector<float> still;
  constexpr int kFrames = 20'000;
  for (int frame = 0; frame < kFrames; ++frame) {
    late.push_back(static_cast<float>(1e6 * lateness({.trigger_us = 3, .encoder_mm = 0.004}, 1, frame, 1000)));
    still.push_back(static_cast<float>(1e6 * lateness({.trigger_us = 3, .encoder_mm = 0.004}, 1, frame, 0)));
  }
  EXPECT_NEAR(moments_of(late).deviation, 5, 0.15);  // 3 µs of the trigger and 4 of the encoder
  EXPECT_NEAR(moments_of(still).deviation, 3, 0.1);
  EXPECT_NEAR(moments_of(late).mean, 0, 0.2);
}

// The image is that of a part which lies as much farther as the frame is late.
TEST(Jitter, MovesThePart) {
  const Rig rig = load_rig("light-section");
  LevelScene scene;
  scene.top = 5;
  scene.x0 = -2000;
  scene.x1 = 0;
  scene.fastest = 1000;
  RenderOptions options = ideal();
  options.world.jitter = Jitter{.trigger_us = 0, .encoder_mm = 1.5};
  const FloatImage light(512, 512, 1);
  const Renderer renderer(rig, scene, light, options);
  for (int frame = 0; frame < 4; ++frame) {
    const double late = lateness(*options.world.jitter, static_cast<std::uint64_t>(rig.imaging.seed), frame, 1000);
    LevelScene moved;
    moved.top = 5;
    moved.x0 = -2000 + 1000 * late;
    moved.x1 = 1000 * late;
    moved.fastest = 1000;
    EXPECT_GT(std::abs(late), 1e-5);
    const Frame seen(rig, renderer, frame);
    const Frame expected(rig, Renderer(rig, moved, light, ideal()), frame);
    for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
      ASSERT_NEAR(seen.pixels[i], expected.pixels[i], 0.01) << frame;
    }
  }
}

// A single bright row is seen again `share` as bright, at the stated distance.
TEST(SecondLine, LiesAndShinesAsStated) {
  const SecondLine line{.share = 0.3, .least_rows = 12, .most_rows = 36, .period_mm = 20};
  EXPECT_NEAR(second_line_rows(line, 0), 24, 1e-12);
  EXPECT_NEAR(second_line_rows(line, 5), 36, 1e-12);
  EXPECT_NEAR(second_line_rows(line, 15), 12, 1e-12);
  constexpr int kRows = 96;
  for (const double way : {0.0, 1.3, 7.7}) {
    std::vector<float> image(kRows, 8.0F);
    image[40] = 108;
    image[41] = 58;
    add_second_line(line, way, kRows, 1, 8, image);
    EXPECT_EQ(image[40], 108);
    double sum = 0;
    double first = 0;
    for (int r = 45; r < kRows; ++r) {
      sum += static_cast<double>(image[static_cast<std::size_t>(r)]) - 8;
      first += (static_cast<double>(image[static_cast<std::size_t>(r)]) - 8) * r;
    }
    EXPECT_NEAR(sum, 0.3 * 150, 1e-3);
    EXPECT_NEAR(first / sum, 40 + 1.0 / 3 + second_line_rows(line, way), 1e-4);
  }
}

TEST(World, NamesAndStrengths) {
  const WorldFile file = load_world(kBuiltInWorld);
  const World world = world_of(file, {"gloss=brushed-steel", "defect-pixels", "second-line=0.1"});
  ASSERT_TRUE(world.gloss && world.defect_pixels && world.second_line);
  EXPECT_FALSE(world.texture || world.flicker);
  EXPECT_EQ(world.gloss->reflectance, file.presets[2].second.reflectance);
  EXPECT_EQ(world.defect_pixels->hot, 1e-4);
  EXPECT_EQ(world.second_line->share, 0.1);
  for (const char* wrong : {"glare", "gloss=gold", "second-line=2", "second-line=", "flicker=bright", "=1"}) {
    EXPECT_THROW(world_of(file, {wrong}), UserError) << wrong;
  }
  EXPECT_THROW(world_of(file, {"flicker", "flicker=3"}), UserError);
  EXPECT_THROW(load_world("no-such-world.yaml"), UserError);
}

}  // namespace
}  // namespace selfproj
