// Compares images under whole patterns with those of LineRenderer, which traces every sub-pixel of every frame, and
// with closed forms written out here.

#include "sim/scene/pattern_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::test {
namespace {

sim::RenderOptions without_noise() {
  sim::RenderOptions options;
  options.shot_noise = options.read_noise = options.quantization = false;
  return options;
}

// Rig B with an eighth of the pixels along each side.
rig::Rig small_rig() {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows = 64;
  rig.camera.columns = 64;
  rig.camera.pixel_pitch_mm *= 8;
  rig.projector.lines = 96;
  rig.projector.columns = 128;
  rig.projector.line_pitch_mm *= 8;
  rig.projector.column_pitch_mm *= 8;
  return rig;
}

// A level block on the plane that moves along x, as part of the surface.
class MovingSurface : public sim::Scene {
 public:
  MovingSurface(double x0, double x1, double y0, double y1, double top, double v)
      : x0_(x0), x1_(x1), y0_(y0), y1_(y1), top_(top), v_(v) {}
  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double x, double y, double t) const override {
    return x >= x0_ + v_ * t && x <= x1_ + v_ * t && y >= y0_ && y <= y1_ ? top_ : 0;
  }
  [[nodiscard]] sim::HeightRange range(const sim::Box& b, double t0, double t1) const override {
    const bool on = b.x1 >= x0_ + v_ * t0 && b.x0 <= x1_ + v_ * t1 && b.y1 >= y0_ && b.y0 <= y1_;
    const bool all = b.x0 >= x0_ + v_ * t1 && b.x1 <= x1_ + v_ * t0 && b.y0 >= y0_ && b.y1 <= y1_;
    return {all ? top_ : 0, on ? top_ : 0};
  }
  [[nodiscard]] double speed() const override { return v_; }

 private:
  double x0_, x1_, y0_, y1_, top_, v_;
};

// The bare plane with bodies in front of it.
class BodyScene : public sim::Scene {
 public:
  using Make = std::function<std::vector<std::unique_ptr<sim::Body>>(double)>;
  BodyScene(Make make, double speed) : make_(std::move(make)), speed_(speed) {}
  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double /*x*/, double /*y*/, double /*t*/) const override { return 0; }
  [[nodiscard]] sim::HeightRange range(const sim::Box& /*box*/, double /*t0*/, double /*t1*/) const override {
    return {0, 0};
  }
  [[nodiscard]] double speed() const override { return 0; }
  [[nodiscard]] sim::Bodies bodies(double t) const override { return make_(t); }
  [[nodiscard]] double body_speed() const override { return speed_; }

 private:
  Make make_;
  double speed_;
};

sim::Bodies one(std::unique_ptr<sim::Body> body) {
  sim::Bodies bodies;
  bodies.push_back(std::move(body));
  return bodies;
}

images::FloatImage light_of(const images::Image& image) {
  images::FloatImage light(image.rows, image.columns);
  std::transform(image.pixels.begin(), image.pixels.end(), light.values.begin(),
                 [](std::uint8_t value) { return static_cast<float>(value) / 255; });
  return light;
}

struct Difference {
  double most = 0;
  double mean = 0;
};

Difference difference(const std::vector<float>& a, const std::vector<float>& b) {
  Difference result;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
    result.most = std::max(result.most, d);
    result.mean += d / static_cast<double>(a.size());
  }
  return result;
}

std::vector<float> blank(const rig::Rig& rig) {
  return std::vector<float>(static_cast<std::size_t>(rig.camera.rows) * static_cast<std::size_t>(rig.camera.columns));
}

TEST(GrayPatterns, AreThoseOf41) {
  rig::RigProjector projector = rig::load_rig("scanner").projector;
  projector.columns = 3;
  for (const int lines : {768, 96, 100, 7}) {
    projector.lines = lines;
    for (const int bits : {1, 4, 8, 12}) {
      const std::vector<images::Image> patterns = sim::gray_patterns(projector, bits);
      ASSERT_EQ(patterns.size(), static_cast<std::size_t>(2 * bits));
      for (int i = 0; i < bits; ++i) {
        for (int y = 0; y < lines; ++y) {
          const double height = std::max<double>(lines, std::pow(2.0, bits));
          const auto g = static_cast<int>(std::fmod(std::floor(std::pow(2.0, i) * y / height + 0.5), 2.0));
          for (int c = 0; c < 3; ++c) {
            const auto at = static_cast<std::size_t>(3 * y + c);
            ASSERT_EQ(patterns[static_cast<std::size_t>(2 * i)].pixels[at], g == 1 ? 255 : 0);
            ASSERT_EQ(patterns[static_cast<std::size_t>(2 * i + 1)].pixels[at], g == 1 ? 0 : 255);
          }
        }
      }
    }
  }
  EXPECT_THROW(sim::gray_patterns(projector, 0), std::invalid_argument);
  EXPECT_THROW(sim::gray_patterns(projector, 13), std::invalid_argument);
}

// Steps, slopes and shadows that do not move, under coarse and fine patterns, with and without falloff.
TEST(PatternRenderer, StillSurfaceLooksAsWithRenderer) {
  const rig::Rig rig = small_rig();
  images::FloatImage heights(40, 50);
  for (int r = 0; r < heights.rows; ++r) {
    for (int c = 0; c < heights.columns; ++c) {
      heights.row(r)[c] = r < 20 ? 60 : 30 + 20 * std::sin(static_cast<float>(c) * 0.2F);
    }
  }
  const std::unique_ptr<sim::Scene> scene = sim::height_map_scene(heights, 4, rig);
  const std::vector<images::Image> patterns = sim::gray_patterns(rig.projector, 5);
  for (const bool falloff : {false, true}) {
    sim::RenderOptions options = without_noise();
    options.falloff = falloff;
    const sim::PatternRenderer renderer(rig, *scene, options);
    for (const std::size_t pattern : {0U, 3U, 8U, 9U}) {
      const sim::LineRenderer traced(rig, *scene, light_of(patterns[pattern]), options);
      std::vector<float> want = blank(rig);
      std::vector<float> got = blank(rig);
      traced.render(0, std::span<float>(want));
      renderer.render(0, sim::project_image(rig, patterns[pattern]), std::span<float>(got));
      const Difference d = difference(want, got);
      EXPECT_LT(d.most, 0.5) << "pattern " << pattern;
      EXPECT_LT(d.mean, 0.02) << "pattern " << pattern;
      EXPECT_GT(*std::max_element(want.begin(), want.end()), 50);
    }
  }
}

// The same block on the plane, once as part of the surface and once as a body, moves by several pixels in an exposure.
// Compares faces, edges, shadow and blur. Corners of its shadow that fall between the nodes of a block are missed.
TEST(PatternRenderer, MovingBlockLooksAsWithRenderer) {
  rig::Rig rig = small_rig();
  constexpr double kTop = 50;
  for (const double v : {0.0, 4000.0, 30000.0}) {
    const MovingSurface surface(-60, 20, -50, 70, kTop, v);
    const BodyScene bodies(
        [&](double t) {
          return one(std::make_unique<sim::Block>(
              sim::Cuboid{{-60 + v * t, -50, rig.plane_z_mm - kTop}, {20 + v * t, 70, rig.plane_z_mm + 1}}));
        },
        v);
    const std::vector<images::Image> patterns = sim::gray_patterns(rig.projector, 5);
    const sim::PatternRenderer renderer(rig, bodies, without_noise());
    for (const std::size_t pattern : {1U, 8U}) {
      const sim::LineRenderer traced(rig, surface, light_of(patterns[pattern]), without_noise());
      const sim::ProjectedLight light = sim::project_image(rig, patterns[pattern]);
      for (const int frame : {0, 2}) {
        std::vector<float> want = blank(rig);
        std::vector<float> got = blank(rig);
        traced.render(frame, std::span<float>(want));
        renderer.render(frame, light, std::span<float>(got));
        const Difference d = difference(want, got);
        EXPECT_LT(d.most, 6) << "v " << v << ", pattern " << pattern << ", frame " << frame;
        EXPECT_LT(d.mean, 0.05) << "v " << v << ", pattern " << pattern << ", frame " << frame;
      }
    }
  }
}

// Half an ellipsoid on the plane, as a surface and as a body. Parabolas through a few rays find curved surfaces.
class MovingDome : public sim::Scene {
 public:
  MovingDome(double rx, double ry, double top, double v) : rx_(rx), ry_(ry), top_(top), v_(v) {}
  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double x, double y, double t) const override {
    const double u = (x - v_ * t) / rx_;
    const double w = y / ry_;
    return top_ * std::sqrt(std::max(0.0, 1 - u * u - w * w));
  }
  [[nodiscard]] sim::HeightRange range(const sim::Box& b, double t0, double t1) const override {
    const double x0 = b.x0 - v_ * t1;
    const double x1 = b.x1 - v_ * t0;
    const auto near = [](double low, double high) { return std::clamp(0.0, low, high); };
    const auto far = [](double low, double high) { return std::max(-low, high); };
    return {height(far(x0, x1), far(b.y0, b.y1), 0), height(near(x0, x1), near(b.y0, b.y1), 0)};
  }
  [[nodiscard]] double speed() const override { return v_; }

 private:
  double rx_, ry_, top_, v_;
};

TEST(PatternRenderer, MovingDomeLooksAsWithRenderer) {
  rig::Rig rig = small_rig();
  constexpr double kTop = 60;
  for (const double v : {0.0, 15000.0}) {
    const MovingDome surface(150, 110, kTop, v);
    const BodyScene bodies(
        [&](double t) {
          return one(std::make_unique<sim::Ellipsoid>(sim::Point3{v * t, 0, rig.plane_z_mm},
                                                      std::array<sim::Point3, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                                      sim::Point3{150, 110, kTop}));
        },
        v);
    const std::vector<images::Image> patterns = sim::gray_patterns(rig.projector, 5);
    const sim::PatternRenderer renderer(rig, bodies, without_noise());
    for (const std::size_t pattern : {1U, 8U}) {
      const sim::LineRenderer traced(rig, surface, light_of(patterns[pattern]), without_noise());
      std::vector<float> want = blank(rig);
      std::vector<float> got = blank(rig);
      traced.render(1, std::span<float>(want));
      renderer.render(1, sim::project_image(rig, patterns[pattern]), std::span<float>(got));
      const Difference d = difference(want, got);
      EXPECT_LT(d.most, 6) << "v " << v << ", pattern " << pattern;
      EXPECT_LT(d.mean, 0.05) << "v " << v << ", pattern " << pattern;
    }
  }
}

// What a pixel sees of a hovering ball, of a finger and of the plane behind them, and which parts of the plane are
// dark.
TEST(PatternRenderer, DepthOfBodiesAndTheirShadows) {
  const rig::Rig rig = small_rig();
  const sim::Point3 centre{10, 20, 430};
  constexpr double kRadius = 45;
  const BodyScene ball(
      [&](double /*t*/) {
        return one(std::make_unique<sim::Ellipsoid>(centre,
                                                    std::array<sim::Point3, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                                    sim::Point3{kRadius, kRadius, kRadius}));
      },
      0);
  const sim::Point3 a{-80, -100, 470};
  const sim::Point3 b{60, -120, 450};
  const BodyScene finger([&](double /*t*/) { return one(std::make_unique<sim::Capsule>(a, b, 15)); }, 0);

  // Whether a straight line from p along d comes closer than r to the point c, or to a line from c to e.
  const auto distance_to = [](sim::Point3 p, sim::Point3 c, sim::Point3 e) {
    const sim::Point3 axis = e - c;
    const double length_2 = sim::dot(axis, axis);
    const double s = length_2 > 0 ? std::clamp(sim::dot(p - c, axis) / length_2, 0.0, 1.0) : 0;
    const sim::Point3 d = p - (c + s * axis);
    return std::sqrt(sim::dot(d, d));
  };
  struct Case {
    const BodyScene* scene;
    sim::Point3 c, e;
    double radius;
  };
  for (const Case& test : {Case{&ball, centre, centre, kRadius}, Case{&finger, a, b, 15}}) {
    const sim::PatternRenderer renderer(rig, *test.scene, without_noise());
    std::vector<float> z = blank(rig);
    std::vector<float> lit = blank(rig);
    renderer.depth(0, z);
    renderer.lit_depth(0, lit);
    const sim::Point3 projector{rig.projector.x_mm, 0, rig.projector.z_mm};
    // The first point within the radius, in small steps along the line from p to q; 1 if there is none.
    const auto first = [&](sim::Point3 p, sim::Point3 q) {
      constexpr int kSteps = 4000;
      for (int i = 0; i <= kSteps; ++i) {
        const double s = static_cast<double>(i) / kSteps;
        if (distance_to(p + s * (q - p), test.c, test.e) < test.radius) {
          return s;
        }
      }
      return 1.0;
    };
    int on_body = 0;
    int in_shadow = 0;
    for (int r = 0; r < rig.camera.rows; r += 3) {
      for (int c = 0; c < rig.camera.columns; c += 3) {
        const double scale = rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
        const sim::Point3 on_plane{rig.plane_z_mm * scale * (r - 31.5), rig.plane_z_mm * scale * (c - 31.5),
                                   rig.plane_z_mm};
        const double s = first({0, 0, 0}, on_plane);
        const auto at = static_cast<std::size_t>(r * rig.camera.columns + c);
        ASSERT_NEAR(static_cast<double>(z[at]), s * rig.plane_z_mm, 0.3) << r << ", " << c;
        on_body += s < 1 ? 1 : 0;
        if (s == 1) {
          const double nearest = first(on_plane, projector);
          // Skips points nearer to a shadow's edge than the steps can tell.
          if (nearest == 1) {
            EXPECT_FALSE(std::isnan(lit[at])) << r << ", " << c;
          } else {
            EXPECT_TRUE(std::isnan(lit[at])) << r << ", " << c;
            ++in_shadow;
          }
        }
      }
    }
    EXPECT_GT(on_body, 5);
    EXPECT_GT(in_shadow, 5);
  }
}

// Ellipsoids with random axes: every point that a ray meets lies on the surface, and its normal is perpendicular to it.
TEST(Body, RaysMeetAnEllipsoidOnItsSurface) {
  const double angle = 0.6;
  const std::array<sim::Point3, 3> axes{
      {{std::cos(angle), std::sin(angle), 0}, {-std::sin(angle), std::cos(angle), 0}, {0, 0, 1}}};
  const sim::Point3 half{40, 25, 10};
  const sim::Point3 centre{5, -8, 400};
  const sim::Ellipsoid body(centre, axes, half);
  const auto value = [&](sim::Point3 p) {
    const sim::Point3 d = p - centre;
    const double u = sim::dot(d, axes[0]) / half.x;
    const double v = sim::dot(d, axes[1]) / half.y;
    const double w = sim::dot(d, axes[2]) / half.z;
    return u * u + v * v + w * w;
  };
  int met = 0;
  for (double x = -0.2; x <= 0.2; x += 0.01) {
    for (double y = -0.2; y <= 0.2; y += 0.01) {
      const sim::Ray ray{{0, 0, 0}, {x, y, 1}};
      sim::Meeting meeting;
      if (!body.meets(ray, 1000, meeting)) {
        continue;
      }
      ++met;
      const sim::Point3 p = ray.from + meeting.s * ray.along;
      EXPECT_NEAR(value(p), 1, 1e-9);
      EXPECT_LT(sim::dot(meeting.normal, ray.along), 0);
      const double inside = value(p - 1e-4 * meeting.normal);
      const double outside = value(p + 1e-4 * meeting.normal);
      EXPECT_LT(inside, 1);
      EXPECT_GT(outside, 1);
      EXPECT_TRUE(body.blocks(ray, 1000));
      EXPECT_FALSE(body.blocks(ray, meeting.s * 0.99));
      const sim::Cuboid box = body.bounds();
      EXPECT_TRUE(p.x >= box.low.x && p.x <= box.high.x && p.y >= box.low.y && p.y <= box.high.y && p.z >= box.low.z);
    }
  }
  EXPECT_GT(met, 100);
}

TEST(PatternRenderer, ImagesDependOnSeedAndFrameAloneNotOnOrder) {
  rig::Rig rig = small_rig();
  const BodyScene scene(
      [](double t) {
        return one(std::make_unique<sim::Capsule>(sim::Point3{-50 + 2000 * t, 0, 450}, sim::Point3{50, 10, 470}, 20));
      },
      2000);
  const sim::PatternSet patterns(rig, sim::gray_patterns(rig.projector, 3));
  const auto image = [&](const sim::PatternRenderer& renderer, int frame) {
    std::vector<std::uint8_t> pixels(blank(rig).size());
    renderer.render(frame, patterns.of_frame(frame), std::span<std::uint8_t>(pixels));
    return pixels;
  };
  const sim::PatternRenderer one_thread(rig, scene, {}, 1);
  const sim::PatternRenderer more(rig, scene, {}, 3);
  const std::vector<std::uint8_t> five = image(one_thread, 5);
  EXPECT_EQ(image(more, 3), image(one_thread, 3));
  EXPECT_EQ(image(more, 5), five);
  EXPECT_NE(image(more, 11), five);  // the same pattern
  rig.imaging.seed = 2;
  EXPECT_NE(image(sim::PatternRenderer(rig, scene), 5), five);
}

TEST(PatternRenderer, RefusesWhatItCannotShow) {
  const rig::Rig rig = small_rig();
  const MovingSurface moving(-60, 20, -50, 70, 10, 5);
  EXPECT_THROW(sim::PatternRenderer(rig, moving), std::invalid_argument);
  const BodyScene many(
      [](double /*t*/) {
        sim::Bodies bodies;
        for (int i = 0; i < 33; ++i) {
          bodies.push_back(std::make_unique<sim::Capsule>(sim::Point3{0, 0, 400}, sim::Point3{0, 0, 410}, 5));
        }
        return bodies;
      },
      0);
  EXPECT_THROW(sim::PatternRenderer(rig, many), std::invalid_argument);
  EXPECT_THROW(sim::PatternSet(rig, std::vector<images::Image>{}), std::invalid_argument);
  try {
    sim::project_image(rig, images::Image{2, 3, std::vector<std::uint8_t>(6)}, {}, "stripes.png");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(), "stripes.png: has 2 lines of 3 columns; the rig's projector has 96 of 128");
  }
  EXPECT_THROW(sim::Capsule({0, 0, 0}, {0, 0, 1}, 0), std::invalid_argument);
  EXPECT_THROW(sim::Ellipsoid({0, 0, 0}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {1, 0, 1}), std::invalid_argument);
  EXPECT_THROW(sim::Block({{0, 0, 0}, {1, 1, 0}}), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
