// Gloss, texture, bounce of light, defocus and projector gamma against the closed forms of textbooks.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/bounce.h"
#include "sim/scene/defocus.h"
#include "sim/scene/gloss.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/projector_gamma.h"
#include "sim/scene/renderer.h"
#include "sim/scene/texture.h"
#include "tests/sim/level_scene.h"

namespace selfproj {
namespace {

using test::Frame;
using test::ideal;
using test::LevelScene;

constexpr double kPi = std::numbers::pi;

Point3 direction(double polar, double azimuth) {
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
}

// The integral of D cos over the half space is 1 (Walter et al. 2007).
TEST(Gloss, FacetsCoverTheSurfaceOnce) {
  for (const double roughness : {0.1, 0.3, 0.5}) {
    double sum = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double polar = (i + 0.5) / kSteps * kPi / 2;
      sum += facets(std::cos(polar), roughness) * std::cos(polar) * 2 * kPi * std::sin(polar) * kPi / 2 / kSteps;
    }
    EXPECT_NEAR(sum, 1, 1e-4) << roughness;
  }
}

// Helmholtz: light and camera can change places. And no surface throws back more than it gets.
TEST(Gloss, IsReciprocalAndKeepsEnergy) {
  const Point3 up{0, 0, 1};
  const Gloss gloss{0, 0.53, 0.3};
  for (const double polar : {0.1, 0.6, 1.1}) {
    const Point3 light = direction(polar, 0.3);
    const Point3 view = direction(0.4, 2.0);
    EXPECT_NEAR(relative_radiance(gloss, 1, up, light, view), relative_radiance(gloss, 1, up, view, light), 1e-12);
    double thrown = 0;  // the integral of f cos over all directions of the camera; f = relative / π
    constexpr int kSteps = 300;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double out = (i + 0.5) / kSteps * kPi / 2;
        const Point3 to = direction(out, (j + 0.5) / kSteps * 2 * kPi);
        thrown += relative_radiance(gloss, 1, up, light, to) / kPi * std::cos(out) * std::sin(out) * kPi / 2 * 2 * kPi /
                  kSteps / kSteps;
      }
    }
    EXPECT_LE(thrown, 1);
    EXPECT_GE(thrown, 0.4);  // most of the 0.53 and more by Fresnel, less what the facets hide
  }
}

// At normal incidence seen from above: D = 1/(π m²), F = R, G = 1, so that the radiance is diffuse + R / (4 m²).
TEST(Gloss, PlaneSeenFromTheLight) {
  const Gloss gloss{0.6, 0.04, 0.15};
  EXPECT_NEAR(relative_radiance(gloss, 0.5, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}), 0.3 + 0.04 / (4 * 0.15 * 0.15), 1e-12);
}

// What the camera of rig A sees of the plane in the middle of its image, by the angles of the rig alone: the projector
// stands at the angle i to the normal, the camera looks along it, and the facets lean by i/2.
TEST(Gloss, RendererShowsTheClosedForm) {
  Rig rig = load_rig("light-section");
  rig.camera.rows = 97;  // a pixel in the middle
  rig.camera.columns = 5;
  const LevelScene scene;
  RenderOptions options = ideal();
  options.world.gloss = Gloss{0.5, 0.2, 0.3};
  const Frame frame(rig, Renderer(rig, scene, FloatImage(512, 512, 1), options), 0);
  const double i = std::atan2(rig.projector.x_mm, rig.plane_z_mm - rig.projector.z_mm);
  const double tan_2 = std::pow(std::tan(i / 2), 2);
  const double d = std::exp(-tan_2 / 0.09) / (kPi * 0.09 * std::pow(std::cos(i / 2), 4));
  const double f = 0.2 + 0.8 * std::pow(1 - std::cos(i / 2), 5);
  const double share = 0.5 + kPi * d * f / (4 * std::cos(i));  // nothing hides facets at these angles
  const double white = rig.imaging.white - rig.imaging.ambient;
  EXPECT_NEAR(frame.at(48, 2), rig.imaging.ambient + white * std::cos(i) * share, 0.05);
}

TEST(Texture, HasItsContrastAndCorrelation) {
  const TextureField field({.contrast = 0.2, .scale_mm = 2}, 7);
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
  Rig rig = load_rig("light-section");
  rig.camera.columns = 8;
  LevelScene scene;
  const double row_mm = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  scene.fastest = 5 * row_mm * rig.camera.frame_rate_hz;
  RenderOptions options = ideal();
  options.world.texture = Texture{0.3, 2};
  const Renderer renderer(rig, scene, FloatImage(512, 512, 1), options);
  const Frame first(rig, renderer, 0);
  const Frame second(rig, renderer, 1);
  const double tilt = std::atan2(rig.projector.x_mm, rig.plane_z_mm - rig.projector.z_mm);
  for (int r = 20; r < 70; ++r) {  // the incidence changes by less than 0.2 % over five rows
    EXPECT_NEAR(second.at(r + 5, 3) / first.at(r, 3), 1, 0.005 / std::cos(tilt)) << r;
  }
}

// A groove of two planes at 45° that meet at a right angle along x: height |y| up to a rim.
class Groove final : public Scene {
 public:
  explicit Groove(double rim) : rim_(rim) {}
  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double /*x*/, double y, double /*t*/) const override {
    return std::min(std::abs(y), rim_);
  }
  [[nodiscard]] HeightRange range(const Box& box, double /*t0*/, double /*t1*/) const override {
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
  const Rig rig = load_rig("light-section");
  constexpr double kRim = 8;
  const Groove scene(kRim);
  const LitSurface surface(rig, scene, false);
  const BounceLight bounce(rig, scene, surface, {1});
  const ProjectedLight pattern(FloatImage(rig.projector.lines, rig.projector.columns, 1), 0);
  const double width = kRim * std::numbers::sqrt2;
  const Point3 normal = 1 / std::numbers::sqrt2 * Point3{0, -1, -1};  // of the wall at y > 0
  const Point3 other = 1 / std::numbers::sqrt2 * Point3{0, 1, -1};
  for (const double y : {2.0, 4.0, 6.0}) {
    const double s = y * std::numbers::sqrt2;
    const Point3 point{0, y, rig.plane_z_mm - y};
    const double lit = surface.incidence({0, -kRim / 2, rig.plane_z_mm - kRim / 2}, other);
    EXPECT_NEAR(bounce.irradiance(pattern, 0, point, normal), lit * (1 - s / std::hypot(s, width)) / 2, 0.02 * lit)
        << y;
  }
}

// A level plane lights no part of itself.
TEST(Bounce, PlaneIsNotLitByItself) {
  Rig rig = load_rig("light-section");
  const LevelScene scene;
  RenderOptions options = ideal();
  const Frame without(rig, Renderer(rig, scene, FloatImage(512, 512, 1), options), 0);
  options.world.bounce = Bounce{1};
  const Frame with(rig, Renderer(rig, scene, FloatImage(512, 512, 1), options), 0);
  EXPECT_EQ(with.pixels, without.pixels);
}

// The circle of confusion of a thin lens (Hecht): f = 50, N = 4, focused at 1167 mm, an object at 1128 mm:
// c = f²/N · 39 / (1128 · 1117) = 0.019346 mm.
TEST(Defocus, ThinLens) {
  const FocusedLens lens(50, 4, 0.01, 1167);
  EXPECT_NEAR(lens.sigma_px(1128) * 4 * 0.01, 0.0193457, 1e-6);
  EXPECT_EQ(lens.sigma_px(1167), 0);
}

TEST(Defocus, SpreadHasItsVarianceAndKeepsLight) {
  for (const double sigma : {0.2, 0.5, 0.9, 2.3}) {
    constexpr int kSide = 41;
    std::vector<float> image(kSide * kSide, 0.0F);
    image[kSide * 20 + 20] = 1;
    const std::vector<float> sigmas(image.size(), static_cast<float>(sigma));
    spread(kSide, kSide, sigmas, image);
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
  Rig rig = load_rig("light-section");
  LevelScene scene;
  scene.floor = 30;
  const double line = std::round(test::line_at(rig, 0, rig.plane_z_mm - scene.floor));
  FloatImage pattern(512, 512);
  std::fill_n(pattern.row(static_cast<int>(line)), 512, 1.0F);
  const auto variance = [&](const World& world) {
    RenderOptions options = ideal();
    options.camera_blur = true;  // whose margin gathers light from outside
    options.world = world;
    const Frame frame(rig, Renderer(rig, scene, pattern, options), 0);
    const double middle = frame.centroid(256, rig.imaging.ambient);
    double m2 = 0;
    for (int r = 0; r < frame.rows; ++r) {
      m2 += (frame.at(r, 256) - rig.imaging.ambient) * std::pow(r - middle, 2);
    }
    return m2 / frame.sum(256, rig.imaging.ambient);
  };
  const double sharp = variance({});
  World camera;
  camera.camera_defocus = Defocus{4, 0};
  const double c = 2500.0 / 4 * 30 / (1137.0 * 1117) / 0.01;  // pixels
  EXPECT_NEAR(variance(camera) - sharp, c * c / 16, 0.02);
  World projector;
  projector.projector_defocus = Defocus{4, 0};
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
  EXPECT_NEAR(light_through({2.2, 1}, 0.5F), std::pow(128 / 255.0, 2.2), 1e-6);
  for (const float light : {0.0F, 0.1F, 0.3F, 0.7F, 1.0F}) {
    EXPECT_NEAR(light_through({2.2, 2.2}, light), light, 2.2 / 2 / 255);  // half a level
    EXPECT_NEAR(light_through({1, 1}, light), light, 0.5 / 255 + 1e-6);
  }
}

// A level plane under an even half light shows the power.
TEST(ProjectorGamma, RendererShowsIt) {
  Rig rig = load_rig("light-section");
  rig.camera.columns = 8;
  const LevelScene scene;
  RenderOptions options = ideal();
  const Frame full(rig, Renderer(rig, scene, FloatImage(512, 512, 1), options), 0);
  options.world.gamma = ProjectorGamma{2.2, 1};
  const Frame half(rig, Renderer(rig, scene, FloatImage(512, 512, 0.5F), options), 0);
  const double ambient = rig.imaging.ambient;
  EXPECT_NEAR((half.at(48, 4) - ambient) / (full.at(48, 4) - ambient), std::pow(128 / 255.0, 2.2), 1e-5);
}

// Both renderers show the same world.
TEST(Disturbances, BothRenderersAgree) {
  Rig rig = load_rig("light-section");
  rig.camera.columns = 64;
  LevelScene scene;
  scene.floor = 5;
  scene.top = 25;
  scene.x0 = -4;
  scene.x1 = 3;
  RenderOptions options = ideal();
  options.camera_blur = options.projector_blur = true;
  World& world = options.world;
  world.gloss = Gloss{0.6, 0.04, 0.15};
  world.texture = Texture{0.2, 2};
  world.bounce = Bounce{1};
  world.camera_defocus = Defocus{4, 0};
  world.projector_defocus = Defocus{2, 0};
  world.second_line = SecondLine{0.3, 12, 36, 20};
  FloatImage pattern(512, 512);
  for (int l = 0; l < 500; l += 40) {
    std::fill_n(pattern.row(l), 512 * 8, 1.0F);
  }
  const Frame line(rig, Renderer(rig, scene, pattern, options), 0);
  std::vector<float> whole(rig.camera.pixels());
  PatternRenderer(rig, scene, options).render(0, throw_light(rig, pattern, options), std::span<float>(whole));
  double sum = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    sum += std::abs(static_cast<double>(whole[i]) - static_cast<double>(line.pixels[i]));
  }
  EXPECT_LT(sum / static_cast<double>(whole.size()), 0.05);
}

}  // namespace
}  // namespace selfproj
