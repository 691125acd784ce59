// Gloss, texture, bounce of light, defocus and projector gamma against the closed forms of textbooks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "host/light_section/pattern.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/camera_errors.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/optics.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/world.h"
#include "tests/sim/level_scene.h"

namespace selfproj::test {
namespace {

constexpr double kPi = std::numbers::pi;

sim::Point3 direction(double polar, double azimuth) {
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
}

// The integral of D cos over the half space is 1 (Walter et al. 2007).
TEST(Gloss, FacetsCoverTheSurfaceOnce) {
  for (const double roughness : {0.1, 0.3, 0.5}) {
    double sum = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double polar = (i + 0.5) / kSteps * kPi / 2;
      sum += sim::facets(std::cos(polar), roughness) * std::cos(polar) * 2 * kPi * std::sin(polar) * kPi / 2 / kSteps;
    }
    EXPECT_NEAR(sum, 1, 1e-4) << roughness;
  }
}

// Helmholtz: light and camera can change places. And no surface throws back more than it gets.
TEST(Gloss, IsReciprocalAndKeepsEnergy) {
  const sim::Point3 up{0, 0, 1};
  const sim::Gloss gloss{0, 0.53, 0.3};
  for (const double polar : {0.1, 0.6, 1.1}) {
    const sim::Point3 light = direction(polar, 0.3);
    const sim::Point3 view = direction(0.4, 2.0);
    EXPECT_NEAR(sim::relative_radiance(gloss, 1, up, light, view), sim::relative_radiance(gloss, 1, up, view, light),
                1e-12);
    double thrown = 0;  // the integral of f cos over all directions of the camera; f = relative / π
    constexpr int kSteps = 300;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double out = (i + 0.5) / kSteps * kPi / 2;
        const sim::Point3 to = direction(out, (j + 0.5) / kSteps * 2 * kPi);
        thrown += sim::relative_radiance(gloss, 1, up, light, to) / kPi * std::cos(out) * std::sin(out) * kPi / 2 * 2 *
                  kPi / kSteps / kSteps;
      }
    }
    EXPECT_LE(thrown, 1);
    EXPECT_GE(thrown, 0.4);  // most of the 0.53 and more by Fresnel, less what the facets hide
  }
}

// At normal incidence seen from above: D = 1/(π m²), F = R, G = 1, so that the radiance is diffuse + R / (4 m²).
TEST(Gloss, PlaneSeenFromTheLight) {
  const sim::Gloss gloss{0.6, 0.04, 0.15};
  EXPECT_NEAR(sim::relative_radiance(gloss, 0.5, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}), 0.3 + 0.04 / (4 * 0.15 * 0.15),
              1e-12);
}

// What the camera of rig A sees of the plane in the middle of its image, by the angles of the rig alone: the projector
// stands at the angle i to the normal, the camera looks along it, and the facets lean by i/2.
TEST(Gloss, RendererShowsTheClosedForm) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.rows = 97;  // a pixel in the middle
  rig.camera.columns = 5;
  const LevelScene scene;
  sim::RenderOptions options = ideal();
  options.world.gloss = sim::Gloss{0.5, 0.2, 0.3};
  const Frame frame(rig, sim::LineRenderer(rig, scene, images::FloatImage(512, 512, 1), options), 0);
  const double i = std::atan2(rig.projector.x_mm, rig.plane_z_mm - rig.projector.z_mm);
  const double tan_2 = std::pow(std::tan(i / 2), 2);
  const double d = std::exp(-tan_2 / 0.09) / (kPi * 0.09 * std::pow(std::cos(i / 2), 4));
  const double f = 0.2 + 0.8 * std::pow(1 - std::cos(i / 2), 5);
  const double share = 0.5 + kPi * d * f / (4 * std::cos(i));  // nothing hides facets at these angles
  const double white = rig.imaging.white - rig.imaging.ambient;
  EXPECT_NEAR(frame.at(48, 2), rig.imaging.ambient + white * std::cos(i) * share, 0.05);
}

TEST(Texture, HasItsContrastAndCorrelation) {
  const sim::TextureField field({.contrast = 0.2, .scale_mm = 2}, 7);
  double mean = 0;
  double square = 0;
  double beside = 0;
  constexpr int kSide = 500;
  constexpr double kStep = 0.137;
  constexpr double kLag = 0.5;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const double a = field.at(kStep * i, kStep * j) - 1;
      mean += a;
      square += a * a;
      beside += a * (field.at(kStep * i + kLag, kStep * j) - 1);
    }
  }
  constexpr double kCount = kSide * kSide;
  EXPECT_NEAR(mean / kCount, 0, 0.002);
  EXPECT_NEAR(std::sqrt(square / kCount), 0.2, 0.002);
  EXPECT_NEAR(beside / square, ::j0(2 * kPi * kLag / 2), 0.02);
}

// The texture goes with the part: after the belt has moved it by whole rows, the image has moved by them as well.
TEST(Texture, MovesWithThePart) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.columns = 8;
  LevelScene scene;
  const double row_mm = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  scene.fastest = 5 * row_mm * rig.camera.frame_rate_hz;
  sim::RenderOptions options = ideal();
  options.world.texture = sim::Texture{0.3, 2};
  const sim::LineRenderer renderer(rig, scene, images::FloatImage(512, 512, 1), options);
  const Frame first(rig, renderer, 0);
  const Frame second(rig, renderer, 1);
  const double tilt = std::atan2(rig.projector.x_mm, rig.plane_z_mm - rig.projector.z_mm);
  for (int r = 20; r < 70; ++r) {  // the incidence changes by less than 0.2 % over five rows
    EXPECT_NEAR(second.at(r + 5, 3) / first.at(r, 3), 1, 0.005 / std::cos(tilt)) << r;
  }
}

// A groove of two planes at 45° that meet at a right angle along x: height |y| up to a rim.
class Groove final : public sim::Scene {
 public:
  explicit Groove(double rim) : rim_(rim) {}
  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double /*x*/, double y, double /*t*/) const override {
    return std::min(std::abs(y), rim_);
  }
  [[nodiscard]] sim::HeightRange range(const sim::Box& box, double /*t0*/, double /*t1*/) const override {
    const double low = box.y0 <= 0 && box.y1 >= 0 ? 0 : std::min(std::abs(box.y0), std::abs(box.y1));
    return {std::min(low, rim_), std::min(std::max(std::abs(box.y0), std::abs(box.y1)), rim_)};
  }
  [[nodiscard]] double speed() const override { return 0; }

 private:
  double rim_;
};

// One long wall lights the other: from a strip of width w that meets it at a right angle, a point at the distance s
// from the edge receives (1 - s/√(s² + w²))/2 of the strip's radiosity (Howell, view factors, an element and a long
// strip).
TEST(Bounce, GrooveHasTheViewFactorOfAStrip) {
  const rig::Rig rig = rig::load_rig("light-section");
  constexpr double kRim = 8;
  const Groove scene(kRim);
  const sim::LitSurface surface(rig, scene, false);
  const sim::BounceLight bounce(rig, scene, surface, {1});
  const sim::ProjectedLight pattern(images::FloatImage(rig.projector.lines, rig.projector.columns, 1), 0);
  const double width = kRim * std::numbers::sqrt2;
  const sim::Point3 normal = 1 / std::numbers::sqrt2 * sim::Point3{0, -1, -1};  // of the wall at y > 0
  const sim::Point3 other = 1 / std::numbers::sqrt2 * sim::Point3{0, 1, -1};
  for (const double y : {2.0, 4.0, 6.0}) {
    const double s = y * std::numbers::sqrt2;
    const sim::Point3 point{0, y, rig.plane_z_mm - y};
    const double lit = surface.incidence({0, -kRim / 2, rig.plane_z_mm - kRim / 2}, other);
    EXPECT_NEAR(bounce.irradiance(pattern, 0, point, normal), lit * (1 - s / std::hypot(s, width)) / 2, 0.02 * lit)
        << y;
  }
}

// A level plane lights no part of itself.
TEST(Bounce, PlaneIsNotLitByItself) {
  rig::Rig rig = rig::load_rig("light-section");
  const LevelScene scene;
  sim::RenderOptions options = ideal();
  const Frame without(rig, sim::LineRenderer(rig, scene, images::FloatImage(512, 512, 1), options), 0);
  options.world.bounce = sim::Bounce{1};
  const Frame with(rig, sim::LineRenderer(rig, scene, images::FloatImage(512, 512, 1), options), 0);
  EXPECT_EQ(with.pixels, without.pixels);
}

// The circle of confusion of a thin lens (Hecht): f = 50, N = 4, focused at 1167 mm, an object at 1128 mm:
// c = f²/N · 39 / (1128 · 1117) = 0.019346 mm.
TEST(Defocus, ThinLens) {
  const sim::FocusedLens lens(50, 4, 0.01, 1167);
  EXPECT_NEAR(lens.sigma_px(1128) * 4 * 0.01, 0.0193457, 1e-6);
  EXPECT_EQ(lens.sigma_px(1167), 0);
}

TEST(Defocus, SpreadHasItsVarianceAndKeepsLight) {
  for (const double sigma : {0.2, 0.5, 0.9, 2.3}) {
    constexpr int kSide = 41;
    std::vector<float> image(kSide * kSide, 0.0F);
    image[kSide * 20 + 20] = 1;
    const std::vector<float> sigmas(image.size(), static_cast<float>(sigma));
    sim::spread(kSide, kSide, sigmas, image);
    double sum = 0;
    double down = 0;
    double across = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const auto value = static_cast<double>(image[static_cast<std::size_t>(i)]);
      sum += value;
      down += value * std::pow(i / kSide - 20, 2);
      across += value * std::pow(i % kSide - 20, 2);
    }
    EXPECT_NEAR(sum, 1, 1e-5);
    EXPECT_NEAR(down, sigma * sigma, 0.02 * sigma * sigma + 0.01) << sigma;
    EXPECT_NEAR(across, sigma * sigma, 0.02 * sigma * sigma + 0.01) << sigma;
  }
}

// A line on a plane that lies out of focus: the variances of the image along rows add, pixel, line, projector and
// camera. The projector's pixels are seen at the scale that the angles give.
TEST(Defocus, VariancesOfALineAdd) {
  rig::Rig rig = rig::load_rig("light-section");
  LevelScene scene;
  scene.floor = 30;
  const double line = std::round(line_at(rig, 0, rig.plane_z_mm - scene.floor));
  images::FloatImage pattern(512, 512);
  std::fill_n(pattern.row(static_cast<int>(line)), 512, 1.0F);
  const auto variance = [&](const sim::World& world) {
    sim::RenderOptions options = ideal();
    options.camera_blur = true;  // whose margin gathers light from outside
    options.world = world;
    const Frame frame(rig, sim::LineRenderer(rig, scene, pattern, options), 0);
    const double middle = frame.centroid(256, rig.imaging.ambient);
    double m2 = 0;
    for (int r = 0; r < frame.rows; ++r) {
      m2 += (frame.at(r, 256) - rig.imaging.ambient) * std::pow(r - middle, 2);
    }
    return m2 / frame.sum(256, rig.imaging.ambient);
  };
  const double sharp = variance({});
  sim::World camera;
  camera.camera_defocus = sim::Defocus{4, 0};
  const double c = 2500.0 / 4 * 30 / (1137.0 * 1117) / 0.01;  // pixels
  EXPECT_NEAR(variance(camera) - sharp, c * c / 16, 0.02);
  sim::World projector;
  projector.projector_defocus = sim::Defocus{4, 0};
  // distances along the projector's axis of the middle of the plane and of the point on the block
  const double tilt = rig.projector.tilt_rad;
  const auto along = [&](double z) {
    return (z - rig.projector.z_mm) * std::cos(tilt) + rig.projector.x_mm * std::sin(tilt);
  };
  const double focus = along(rig.plane_z_mm);
  const double depth = along(rig.plane_z_mm - 30);
  const double disc = 400.0 / 4 * std::abs(depth - focus) / (depth * (focus - 20)) / std::sqrt(0.00614 * 0.00702);
  const auto row_lit_by = [&](double of_line) {  // (3.4): z is 1137, so x = x0 - (z - z0) tan θ
    const double x = rig.projector.x_mm - (1137 - rig.projector.z_mm) * test::tan_theta(rig, of_line);
    return test::row_of(rig, x / 1137);
  };
  const double rows_per_line = row_lit_by(line + 0.5) - row_lit_by(line - 0.5);
  EXPECT_NEAR((variance(projector) - sharp) / (disc * disc / 16 * rows_per_line * rows_per_line), 1, 0.05);
}

// Rec. IEC 61966: half the level of a gamma of 2.2 is 21.8 % of the light; sent through its inverse it is the light.
TEST(ProjectorGamma, PowerAndItsInverse) {
  EXPECT_NEAR(sim::light_through({2.2, 1}, 0.5F), std::pow(128 / 255.0, 2.2), 1e-6);
  for (const float light : {0.0F, 0.1F, 0.3F, 0.7F, 1.0F}) {
    EXPECT_NEAR(sim::light_through({2.2, 2.2}, light), light, 2.2 / 2 / 255);  // half a level
    EXPECT_NEAR(sim::light_through({1, 1}, light), light, 0.5 / 255 + 1e-6);
  }
}

// A level plane under an even half light shows the power.
TEST(ProjectorGamma, RendererShowsIt) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.columns = 8;
  const LevelScene scene;
  sim::RenderOptions options = ideal();
  const Frame full(rig, sim::LineRenderer(rig, scene, images::FloatImage(512, 512, 1), options), 0);
  options.world.gamma = sim::ProjectorGamma{2.2, 1};
  const Frame half(rig, sim::LineRenderer(rig, scene, images::FloatImage(512, 512, 0.5F), options), 0);
  const double ambient = rig.imaging.ambient;
  EXPECT_NEAR((half.at(48, 4) - ambient) / (full.at(48, 4) - ambient), std::pow(128 / 255.0, 2.2), 1e-5);
}

// Both renderers show the same world.
TEST(Disturbances, BothRenderersAgree) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.columns = 64;
  LevelScene scene;
  scene.floor = 5;
  scene.top = 25;
  scene.x0 = -4;
  scene.x1 = 3;
  sim::RenderOptions options = ideal();
  options.camera_blur = options.projector_blur = true;
  sim::World& world = options.world;
  world.gloss = sim::Gloss{0.6, 0.04, 0.15};
  world.texture = sim::Texture{0.2, 2};
  world.bounce = sim::Bounce{1};
  world.camera_defocus = sim::Defocus{4, 0};
  world.projector_defocus = sim::Defocus{2, 0};
  world.second_line = sim::SecondLine{0.3, 12, 36, 20};
  images::FloatImage pattern(512, 512);
  for (int l = 0; l < 500; l += 40) {
    std::fill_n(pattern.row(l), 512 * 8, 1.0F);
  }
  const Frame line(rig, sim::LineRenderer(rig, scene, pattern, options), 0);
  std::vector<float> whole(rig.camera.pixels());
  sim::PatternRenderer(rig, scene, options).render(0, sim::throw_light(rig, pattern, options), std::span<float>(whole));
  double sum = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    sum += std::abs(static_cast<double>(whole[i]) - static_cast<double>(line.pixels[i]));
  }
  EXPECT_LT(sum / static_cast<double>(whole.size()), 0.05);
}

// Faults of sensor, light and machine against closed forms and statistics.
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
  const sim::FixedPatternMap map({.dsnu_electrons = 40, .prnu = 0.02}, 80, kPixels, 3);
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
  constexpr std::size_t kPixels = 96 * 512;
  double hot = 0;
  double squares = 0;
  constexpr int kCameras = 200;
  for (int camera = 0; camera < kCameras; ++camera) {
    const sim::DefectMap map({.hot = 1e-3, .dead = 5e-4, .min_hot_grey = 100}, kPixels,
                             static_cast<std::uint64_t>(camera));
    hot += static_cast<double>(map.hot());
    squares += std::pow(static_cast<double>(map.hot()) - 1e-3 * static_cast<double>(kPixels), 2);
    std::vector<float> image(kPixels, 8.0F);
    map.apply(2, image);
    EXPECT_EQ(std::count(image.begin(), image.end(), 2.0F), static_cast<std::ptrdiff_t>(map.dead()));
    EXPECT_EQ(std::count_if(image.begin(), image.end(), [](float v) { return v >= 108 && v <= 263; }),
              static_cast<std::ptrdiff_t>(map.hot()));
  }
  EXPECT_NEAR(hot / kCameras, 1e-3 * static_cast<double>(kPixels),
              5 * std::sqrt(1e-3 * static_cast<double>(kPixels) / kCameras));
  EXPECT_NEAR(squares / kCameras / (1e-3 * kPixels), 1, 5 * std::sqrt(2.0 / kCameras));
}

TEST(RowNoise, IsOneOffsetARow) {
  constexpr int kRows = 20'000;
  std::vector<float> image(kRows * 4, 5.0F);
  sim::add_row_noise({.grey = 0.3}, 1, 7, 4, image);
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
  sim::saturate({.exposure = 3, .well_grey = 255}, 2, image);
  EXPECT_EQ(image, (std::vector<float>{2, 32, 152, 255}));
}

// The mean of a sine over an exposure is the sine times sinc.
TEST(Flicker, IsTheMeanOverTheExposure) {
  const sim::Flicker lamp{.grey = 10, .modulation = 0.37, .hz = 100};
  for (const double exposure : {9e-5, 1e-3, 0.01}) {
    for (const double t : {0.0, 0.0013, 0.0071}) {
      double sum = 0;
      constexpr int kSteps = 20000;
      for (int i = 0; i < kSteps; ++i) {
        const double at = t + exposure * ((i + 0.5) / kSteps - 0.5);
        sum += 10 * (1 + 0.37 * std::sin(200 * std::numbers::pi * at)) / kSteps;
      }
      EXPECT_NEAR(sim::flicker_grey(lamp, t, exposure), sum, 1e-6);
    }
  }
  EXPECT_NEAR(sim::flicker_grey(lamp, 0.0025, 0.01), 10, 1e-9) << "a whole period shows no flicker";
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
    sim::move_image(kRows, kColumns, {by, 2 * by}, image);
    EXPECT_NEAR(centre(true) - row, by, 1e-5);
    EXPECT_NEAR(centre(false) - 12, 2 * by, 1e-5);
  }
}

// A belt that swings by dz moves the line by what (3.4) says of the plane at that height.
TEST(Vibration, OfTheBeltIsHeight) {
  const rig::Rig rig = rig::load_rig("light-section");
  const LevelScene scene;
  const images::FloatImage line = light_section::draw_straight_line(rig, line_at(rig, 0, rig.plane_z_mm));
  sim::RenderOptions options = ideal();
  options.camera_blur = true;
  options.world.vibration = sim::Vibration{.belt_mm = 2, .belt_hz = 2500, .camera_px = 0, .camera_hz = 50};
  const sim::LineRenderer renderer(rig, scene, line, options);
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
    late.push_back(static_cast<float>(1e6 * sim::lateness({.trigger_us = 3, .encoder_mm = 0.004}, 1, frame, 1000)));
    still.push_back(static_cast<float>(1e6 * sim::lateness({.trigger_us = 3, .encoder_mm = 0.004}, 1, frame, 0)));
  }
  EXPECT_NEAR(moments_of(late).deviation, 5, 0.15);  // 3 µs of the trigger and 4 of the encoder
  EXPECT_NEAR(moments_of(still).deviation, 3, 0.1);
  EXPECT_NEAR(moments_of(late).mean, 0, 0.2);
}

// The image is that of a part which lies as much farther as the frame is late.
TEST(Jitter, MovesThePart) {
  const rig::Rig rig = rig::load_rig("light-section");
  LevelScene scene;
  scene.top = 5;
  scene.x0 = -2000;
  scene.x1 = 0;
  scene.fastest = 1000;
  sim::RenderOptions options = ideal();
  options.world.jitter = sim::Jitter{.trigger_us = 0, .encoder_mm = 1.5};
  const images::FloatImage light(512, 512, 1);
  const sim::LineRenderer renderer(rig, scene, light, options);
  for (int frame = 0; frame < 4; ++frame) {
    const double late = sim::lateness(*options.world.jitter, static_cast<std::uint64_t>(rig.imaging.seed), frame, 1000);
    LevelScene moved;
    moved.top = 5;
    moved.x0 = -2000 + 1000 * late;
    moved.x1 = 1000 * late;
    moved.fastest = 1000;
    EXPECT_GT(std::abs(late), 1e-5);
    const Frame seen(rig, renderer, frame);
    const Frame expected(rig, sim::LineRenderer(rig, moved, light, ideal()), frame);
    for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
      ASSERT_NEAR(seen.pixels[i], expected.pixels[i], 0.01) << frame;
    }
  }
}

// A single bright row is seen again `share` as bright, at the stated distance.
TEST(SecondLine, LiesAndShinesAsStated) {
  const sim::SecondLine line{.share = 0.3, .min_rows = 12, .max_rows = 36, .period_mm = 20};
  EXPECT_NEAR(sim::second_line_rows(line, 0), 24, 1e-12);
  EXPECT_NEAR(sim::second_line_rows(line, 5), 36, 1e-12);
  EXPECT_NEAR(sim::second_line_rows(line, 15), 12, 1e-12);
  constexpr int kRows = 96;
  for (const double way : {0.0, 1.3, 7.7}) {
    std::vector<float> image(kRows, 8.0F);
    image[40] = 108;
    image[41] = 58;
    sim::add_second_line(line, way, kRows, 1, 8, image);
    EXPECT_EQ(image[40], 108);
    double sum = 0;
    double first = 0;
    for (int r = 45; r < kRows; ++r) {
      sum += static_cast<double>(image[static_cast<std::size_t>(r)]) - 8;
      first += (static_cast<double>(image[static_cast<std::size_t>(r)]) - 8) * r;
    }
    EXPECT_NEAR(sum, 0.3 * 150, 1e-3);
    EXPECT_NEAR(first / sum, 40 + 1.0 / 3 + sim::second_line_rows(line, way), 1e-4);
  }
}

TEST(World, NamesAndStrengths) {
  const sim::WorldFile file = sim::load_world(sim::kBuiltInWorld);
  const sim::World world = sim::world_of(file, {"gloss=brushed-steel", "defect-pixels", "second-line=0.1"});
  ASSERT_TRUE(world.gloss && world.defect_pixels && world.second_line);
  EXPECT_FALSE(world.texture || world.flicker);
  EXPECT_EQ(world.gloss->reflectance, file.presets[2].second.reflectance);
  EXPECT_EQ(world.defect_pixels->hot, 1e-4);
  EXPECT_EQ(world.second_line->share, 0.1);
  for (const char* wrong : {"glare", "gloss=gold", "second-line=2", "second-line=", "flicker=bright", "=1"}) {
    EXPECT_THROW(sim::world_of(file, {wrong}), UserError) << wrong;
  }
  EXPECT_THROW(sim::world_of(file, {"flicker", "flicker=3"}), UserError);
  EXPECT_THROW(sim::load_world("no-such-world.yaml"), UserError);
}

}  // namespace
}  // namespace selfproj::test
