// Tests scenes and how rays meet them, pinholes, and projected light.
#include "sim/scene/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/light_section/pattern.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/moved_scene.h"
#include "sim/scene/optics.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/ring_wave.h"
#include "sim/scene/scenes.h"
#include "sim/scene/targets.h"
#include "tests/support/error_of.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// Rough terrain with cliffs, 40 rows x 30 columns.
images::FloatImage random_map(Random& random) {
  images::FloatImage map(40, 30);
  for (float& value : map.values) {
    value = random.chance(30) ? 30 : static_cast<float>(random.between(0, 100)) / 10;
  }
  return map;
}

std::vector<std::unique_ptr<sim::Scene>> all_scenes(const rig::Rig& rig, Random& random) {
  std::vector<std::unique_ptr<sim::Scene>> all;
  for (const sim::SceneInfo& info : sim::scenes()) {
    all.push_back(sim::make_scene(info.name, rig::load_rig(info.rig())));
  }
  all.push_back(sim::height_map_scene(random_map(random), 2.5, rig));
  return all;
}

// Displaced parts, with the scenes that they come from.
struct MovedPart {
  std::unique_ptr<sim::Scene> part;
  sim::Displacement by;
  std::unique_ptr<sim::MovedScene> moved;
};
std::vector<MovedPart> moved_parts(const rig::Rig& rig, Random& random) {
  std::vector<MovedPart> all;
  const auto value = [&] { return static_cast<double>(random.between(-200, 200)) / 50; };
  for (const char* name : {"mountain", "stairs", "stairs-marked", "map"}) {
    for (int i = 0; i < 3; ++i) {
      MovedPart one{.part = std::string(name) == "map" ? sim::height_map_scene(random_map(random), 2.5, rig)
                                                       : sim::make_scene(name, rig),
                    .by = {.lift_mm = value(), .aside_mm = value(), .turn_deg = i == 0 ? 0 : value()},
                    .moved = nullptr};
      one.moved = std::make_unique<sim::MovedScene>(*one.part, one.by, "options");
      all.push_back(std::move(one));
    }
  }
  return all;
}

// ------------------------------------------------------------------ scenes

TEST(Scene, ListedOnesExistAndNameTheirReference) {
  ASSERT_EQ(sim::scenes().size(), 16U);
  for (const sim::SceneInfo& info : sim::scenes()) {
    const rig::Rig rig = rig::load_rig(info.rig());
    EXPECT_EQ(sim::make_scene(info.name, rig)->frames(), info.frames);
    const sim::SceneInfo& reference = sim::find_scene(info.reference_name());
    EXPECT_EQ(reference.method, info.method) << info.name;
    EXPECT_EQ(reference.cells_below, info.cells_below) << info.name;
    EXPECT_TRUE(reference.reference.empty()) << info.name << ": a reference has no reference of its own";
  }
  EXPECT_EQ(sim::scenes()[3].name, "stairs-marked");
  EXPECT_EQ(sim::scenes()[3].reference, "stairs");
  EXPECT_EQ(sim::scenes()[3].frames, 1400);
  EXPECT_EQ(error_of([] { sim::make_scene("fist", rig::load_rig("light-section")); }),
            "fist: needs a rig of kind scanner; light-section is not one");
}

// The part reaches x = 0 5 mm after the first frame, and has passed by 5 mm at the last.
TEST(Scene, PartsPassAtTheSpeedOfTheConveyor) {
  const rig::Rig rig = rig::load_rig("light-section");
  const auto stairs = sim::make_scene("stairs", rig);
  const auto at = [&](double millimetres) { return stairs->height(0, 0, millimetres / rig.conveyor.speed_mm_per_s); };
  EXPECT_EQ(at(0), 0);
  EXPECT_EQ(at(4.99), 0);
  EXPECT_EQ(at(5.01), 39);
  EXPECT_EQ(at(134.99), 39);
  EXPECT_EQ(at(135.01), 0);
  EXPECT_EQ(stairs->speed(), 1000);
}

TEST(Scene, HeightsAreThoseOfTheExperiments) {
  const rig::Rig rig = rig::load_rig("light-section");
  const double t = 0.07;  // the middle of the part is at x = 0
  const auto mountain = sim::make_scene("mountain", rig);
  EXPECT_NEAR(mountain->height(0, 0, t), 23.6, 1e-9);
  EXPECT_NEAR(mountain->height(30, 49.99, t), 0, 1e-4);
  EXPECT_NEAR(mountain->height(30, 25, t), 23.6 * 0.5625, 1e-9);
  EXPECT_EQ(mountain->height(0, 50.01, t), 0);
  const auto stairs = sim::make_scene("stairs", rig);
  EXPECT_EQ(stairs->height(0, -52.4, t), 30);
  EXPECT_EQ(stairs->height(0, -17.6, t), 30);
  EXPECT_EQ(stairs->height(0, -17.4, t), 39);
  EXPECT_EQ(stairs->height(0, 17.4, t), 39);
  EXPECT_EQ(stairs->height(0, 17.6, t), 21);
  EXPECT_EQ(stairs->height(0, 52.4, t), 21);
  EXPECT_EQ(stairs->height(0, 52.6, t), 0);
  const auto marked = sim::make_scene("stairs-marked", rig);
  EXPECT_EQ(marked->height(9.5, -35, t), 29) << "circle";
  EXPECT_EQ(marked->height(0, -35, t), 30);
  EXPECT_EQ(marked->height(0, 0, t), 38) << "cross";
  EXPECT_EQ(marked->height(9, 9, t), 38);
  EXPECT_EQ(marked->height(9, 0, t), 39);
  // Later frames see smaller x and lie further down: the triangle's base is up, its tip down.
  EXPECT_EQ(marked->height(9.5, 35 + 9, t), 20) << "triangle";
  EXPECT_EQ(marked->height(-9.5, 35, t), 20);
  EXPECT_EQ(marked->height(-9.5, 35 + 9, t), 21);
}

// Compares their extent and the carved share with the strokes they consist of.
TEST(Scene, MarksHaveTheirSizeAndStroke) {
  constexpr double kStep = 0.05;
  constexpr double kHalf = 15;
  for (const sim::Mark mark : {sim::Mark::circle, sim::Mark::cross, sim::Mark::triangle_down}) {
    double left = 0;
    double right = 0;
    double up = 0;
    double down = 0;
    double area = 0;
    for (double r = -kHalf; r < kHalf; r += kStep) {
      for (double d = -kHalf; d < kHalf; d += kStep) {
        if (sim::distance_from_mark(mark, r, d) <= sim::kMarkStroke / 2) {
          left = std::min(left, r);
          right = std::max(right, r);
          up = std::min(up, d);
          down = std::max(down, d);
          area += kStep * kStep;
        }
      }
    }
    EXPECT_NEAR(right - left, 22, 2 * kStep);
    EXPECT_NEAR(down - up, 22, 2 * kStep);
    const double half_circle = M_PI * 1.5 * 1.5 / 2;
    const double bar = 19 * std::sqrt(2) * 3;
    const double expected = mark == sim::Mark::circle  ? M_PI * (11.0 * 11 - 8.0 * 8)
                            : mark == sim::Mark::cross ? 2 * bar + 4 * half_circle - 9
                                                       : 0;
    if (expected > 0) {
      EXPECT_NEAR(area, expected, 1);
    }
  }
}

TEST(Scene, RangeBoundsTheHeightsAndClosesIn) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const rig::Rig rig = rig::load_rig("light-section");
    std::vector<std::unique_ptr<sim::Scene>> scenes = all_scenes(rig, random);
    std::vector<MovedPart> moved = moved_parts(rig, random);
    std::transform(moved.begin(), moved.end(), std::back_inserter(scenes),
                   [](MovedPart& one) { return std::move(one.moved); });
    for (const auto& scene : scenes) {
      for (int i = 0; i < 50; ++i) {
        const double t = uniform(random, 0, 0.14);
        const double size = std::pow(10, uniform(random, -4, 2));
        const double x = uniform(random, -80, 80);
        const double y = uniform(random, -65, 65);
        const sim::Box box{x, x + uniform(random, 0, size), y, y + uniform(random, 0, size)};
        const double t1 = t + uniform(random, 0, 1e-4);
        const sim::HeightRange range = scene->range(box, t, t1);
        for (int k = 0; k < 30; ++k) {
          const double h =
              scene->height(uniform(random, box.x0, box.x1), uniform(random, box.y0, box.y1), uniform(random, t, t1));
          EXPECT_GE(h, range.low);
          EXPECT_LE(h, range.high);
        }
        const sim::HeightRange point = scene->range({x, x, y, y}, t, t);
        EXPECT_NEAR(point.low, point.high, 1e-9);
      }
    }
  }
}

// A point of the part is where it is put, at all times, and the plane stays where it is.
TEST(Scene, MovedPartsLieWhereTheyArePut) {
  Random random(1);
  const rig::Rig rig = rig::load_rig("light-section");
  for (const MovedPart& one : moved_parts(rig, random)) {
    const auto& part = dynamic_cast<const sim::ConveyedScene&>(*one.part);
    const double turn = one.by.turn_deg * std::numbers::pi / 180;
    int on_it = 0;
    for (int i = 0; i < 2000; ++i) {
      const double t = uniform(random, 0, 0.14);
      const double u = uniform(random, -70, 70);  // from the part's middle
      const double v = uniform(random, -60, 60);
      const double x = part.position(t) + std::cos(turn) * u - std::sin(turn) * v;
      const double y = std::sin(turn) * u + std::cos(turn) * v + one.by.aside_mm;
      const double height = part.part_height(u, v);
      const sim::HeightRange near = part.part_range({u - 1e-9, u + 1e-9, v - 1e-9, v + 1e-9});
      if (near.high - near.low > 1e-6) {
        continue;  // at a wall it is rounding that decides
      }
      on_it += height > 0 ? 1 : 0;
      EXPECT_NEAR(one.moved->height(x, y, t), height > 0 ? height + one.by.lift_mm : height, 1e-6);
    }
    EXPECT_GT(on_it, 200);
  }
  EXPECT_EQ(error_of([&] {
              const auto desk = sim::make_scene("desk", rig::load_rig("scanner"));
              const sim::MovedScene moved(*desk, {.lift_mm = 1}, "--lift");
            }),
            "--lift: the scene is no part on a conveyor");
}

TEST(Scene, HeightMapLiesAsHeightsAreMeasured) {
  rig::Rig rig = rig::load_rig("light-section");
  images::FloatImage map(2, 3);
  map.values = {1, 2, 3, 4, std::numeric_limits<float>::quiet_NaN(), 6};
  const auto scene = sim::height_map_scene(map, 10, rig);
  EXPECT_EQ(scene->frames(), 300);
  const double t = 0.015;  // the middle is at x = 0
  EXPECT_NEAR(scene->height(5, -10, t), 1, 1e-6) << "the first row comes first: at the largest x";
  EXPECT_NEAR(scene->height(5, 10, t), 3, 1e-6);
  EXPECT_NEAR(scene->height(-5, -10, t), 4, 1e-6);
  EXPECT_NEAR(scene->height(-5, 0, t), 0, 1e-6) << "NaN is bare plane";
  EXPECT_NEAR(scene->height(0, -10, t), 2.5, 1e-6);
  EXPECT_NEAR(scene->height(0, 5, t), (0.5 * (2 + 3) + 0.5 * (0 + 6)) / 2, 1e-6);
  EXPECT_NEAR(scene->height(9.9, -14.9, t), 1, 1e-6);
  EXPECT_EQ(scene->height(10.1, 0, t), 0);
  EXPECT_EQ(scene->height(0, 15.1, t), 0);
  rig.conveyor.speed_mm_per_s = 0;
  EXPECT_EQ(sim::height_map_scene(map, 10, rig)->frames(), 1);
  EXPECT_NEAR(sim::height_map_scene(map, 10, rig)->height(5, -10, 7), 1, 1e-6);
}

TEST(Scene, ErrorsNameWhatIsWrong) {
  const rig::Rig rig = rig::load_rig("light-section");
  EXPECT_EQ(error_of([&] { sim::make_scene("hill", rig); }),
            "hill: is not a scene; the scenes are plane, mountain, stairs, stairs-marked, desk, fist, pool, waves, "
            "keyboard, keys, cuboids, cuboids-marked, slider, mouse, "
            "block, hands");
  EXPECT_EQ(error_of([&] { sim::height_map_scene({}, 1, rig, "a.tiff"); }), "a.tiff: has no pixels");
  const images::FloatImage map(2, 2, 1);
  for (const double scale : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(error_of([&] { sim::height_map_scene(map, scale, rig); }).find("must be greater than 0"),
              std::string::npos);
  }
  EXPECT_NE(error_of([&] {
              sim::height_map_scene(images::FloatImage(2, 2, 588), 1, rig);
            }).find("must be finite and below 588"),
            std::string::npos);
  EXPECT_NE(error_of([&] { sim::height_map_scene(images::FloatImage(2, 2, INFINITY), 1, rig); }).find("must be finite"),
            std::string::npos);
}

// ------------------------------------------------------------------ rays

// Compares with small steps along the ray.
TEST(Ray, FirstHitAndShadowAreThoseOfSmallSteps) {
  constexpr double kStep = 0.01;  // mm of height
  constexpr double kTop = 70;
  for (const std::uint64_t seed : seeds(10)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const rig::Rig rig = rig::load_rig("light-section");
    for (const auto& scene : all_scenes(rig, random)) {
      for (int i = 0; i < 20; ++i) {
        const double t = uniform(random, 0, 0.14);
        const sim::HeightRay ray{uniform(random, -40, 40), uniform(random, -1, 1), uniform(random, -60, 60),
                                 uniform(random, -1, 1)};
        const auto clearance = [&](double h) { return h - scene->height(ray.x + ray.dx * h, ray.y + ray.dy * h, t); };
        double expected = kTop;
        while (expected > 0 && clearance(expected) > 0) {
          expected -= kStep;
        }
        const double found = sim::first_hit(*scene, ray, t, 0, kTop);
        // Steps may miss an edge that the ray only just touches. Then it must be one.
        if (std::abs(found - expected) > 2 * kStep) {
          EXPECT_GT(found, expected);
          EXPECT_LE(clearance(found - 2 * sim::kHeightTolerance), 2 * kStep);
        }
        const double from = uniform(random, 0, kTop);
        bool blocked = false;
        for (double h = from; h <= kTop; h += kStep) {
          blocked = blocked || clearance(h) < 0;
        }
        if (blocked) {
          EXPECT_TRUE(sim::is_blocked(*scene, ray, t, from, kTop));
        } else if (sim::is_blocked(*scene, ray, t, from, kTop)) {
          double least = kTop;
          for (double h = from; h <= kTop; h += kStep / 50) {
            least = std::min(least, clearance(h));
          }
          EXPECT_LT(least, kStep);
        }
      }
    }
  }
}

// ------------------------------------------------------------------ pinholes

TEST(Pinhole, CameraIsThatOf33) {
  const rig::RigCamera rig = rig::load_rig("light-section").camera;
  const sim::Pinhole camera = sim::Pinhole::of_camera(rig);
  const sim::PixelPoint p = camera.project({11.67, -23.34, 1167});
  EXPECT_NEAR(p.row, 47.5 + 0.01 / 0.01 * 50, 1e-9);  // Xc = fc x / z = 0.5 mm, a pitch of 0.01 mm
  EXPECT_NEAR(p.column, 255.5 - 0.02 / 0.01 * 50, 1e-9);
}

// θ = θ0 + atan(Xp/fp) is measured from z towards −x, and y = (z − z0) Yp / (fp cos θ0 − Xp sin θ0).
TEST(Pinhole, ProjectorIsThatOf36To38) {
  for (const std::string name : {"light-section", "scanner"}) {
    const rig::RigProjector rig = rig::load_rig(name).projector;
    const sim::Pinhole projector = sim::Pinhole::of_projector(rig);
    Random random(1);
    for (int i = 0; i < 100; ++i) {
      const sim::Point3 p{uniform(random, -100, 50), uniform(random, -100, 100), rig.z_mm + uniform(random, 100, 600)};
      const sim::PixelPoint found = projector.project(p);
      const double xp = rig.center_xp_mm + rig.line_pitch_mm * (found.row - (rig.lines - 1) / 2.0);
      const double yp = rig.center_yp_mm + rig.column_pitch_mm * (found.column - (rig.columns - 1) / 2.0);
      const double theta = rig.tilt_rad + std::atan(xp / rig.focal_length_mm);
      EXPECT_NEAR(std::tan(theta), (rig.x_mm - p.x) / (p.z - rig.z_mm), 1e-9);
      EXPECT_NEAR((p.z - rig.z_mm) * yp / (rig.focal_length_mm * std::cos(rig.tilt_rad) - xp * std::sin(rig.tilt_rad)),
                  p.y, 1e-9);
      // and back
      const sim::Point3 along = projector.ray(found);
      const sim::Point3 again = projector.centre() + projector.depth(p) * along;
      EXPECT_NEAR(again.x, p.x, 1e-9);
      EXPECT_NEAR(again.y, p.y, 1e-9);
      EXPECT_NEAR(again.z, p.z, 1e-9);
    }
  }
}

// ------------------------------------------------------------------ projected light

TEST(ProjectedLight, StraightLineHasItsWidthAndPlace) {
  const rig::Rig all = rig::load_rig("light-section");
  const rig::RigProjector& rig = all.projector;
  for (const double place : {100.0, 100.3, 100.5, 100.9}) {
    const images::FloatImage pattern = light_section::draw_straight_line(all, place);
    double m0 = 0;
    double m1 = 0;
    for (int r = 0; r < rig.lines; ++r) {
      m0 += static_cast<double>(pattern.row(r)[17]);
      m1 += static_cast<double>(pattern.row(r)[17]) * r;
    }
    EXPECT_NEAR(m0, 5, 1e-5);
    EXPECT_NEAR(m1 / m0, place, 1e-5);
    const sim::ProjectedLight light(pattern, 0.7);
    EXPECT_NEAR(light.line_centre(17.4), place, 1e-5);
  }
  EXPECT_TRUE(std::isnan(sim::ProjectedLight(images::FloatImage(4, 4), 0).line_centre(1)));
}

TEST(ProjectedLight, BlurKeepsSumAndMiddleAndWidens) {
  images::FloatImage pattern(40, 50);
  pattern.row(20)[30] = 1;
  for (const double blur : {0.0, 0.4, 0.7, 2.0}) {
    const sim::ProjectedLight light(pattern, blur);
    double m0 = 0;
    double line = 0;
    double column = 0;
    double squares = 0;
    for (int r = 0; r < 40; ++r) {
      for (int c = 0; c < 50; ++c) {
        const double value = light.at({r + 0.0, c + 0.0});
        m0 += value;
        line += value * r;
        column += value * c;
        squares += value * (r - 20) * (r - 20);
        EXPECT_EQ(light.is_dark(r, r, c, c), value == 0) << r << ' ' << c;
      }
    }
    EXPECT_NEAR(m0, 1, 1e-5);
    EXPECT_NEAR(line / m0, 20, 1e-5);
    EXPECT_NEAR(column / m0, 30, 1e-5);
    if (blur > 0.5) {  // a Gaussian narrower than the pixels is no longer one in whole pixels
      EXPECT_NEAR(squares, blur * blur, 0.01 * blur * blur);
    }
    EXPECT_NEAR(light.at({20.5, 30}), (light.at({20, 30}) + light.at({21, 30})) / 2, 1e-7);
    EXPECT_EQ(light.at({-30, 30}), 0);
    EXPECT_TRUE(light.is_dark(-100, -10, -100, 100));
    EXPECT_FALSE(light.is_dark(-100, 100, -100, 100));
  }
}

// What is rendered faster because a scene says that it is smooth and plain, or because sights are kept, is the same to
// the last bit as without; and what the scenes say of themselves is true.

// A scene that says nothing of its smoothness.
class Silent final : public sim::WrappedScene {
 public:
  using sim::WrappedScene::WrappedScene;
  [[nodiscard]] sim::Smoothness smoothness(const sim::Box& /*box*/) const override { return {}; }
  [[nodiscard]] bool is_plain(const sim::Box& /*box*/) const override { return false; }
};

sim::PerturbedRig low_image(std::uint64_t seed) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.rows = 40;
  return sim::hidden_rig(rig, seed);
}

std::vector<float> image_of(const sim::PerturbedRig& actual, const sim::Scene& scene) {
  sim::RenderOptions exact;
  exact.shot_noise = exact.read_noise = exact.quantization = false;
  images::FloatImage pattern(actual.rig.projector.lines, actual.rig.projector.columns);
  for (std::size_t i = 0; i < pattern.values.size(); ++i) {
    pattern.values[i] = i / 1024 % 3 == 0 ? 1.0F : 0.25F;
  }
  std::vector<float> pixels(actual.rig.camera.pixels());
  sim::PatternRenderer(actual, scene, exact).render(0, sim::throw_light(actual.rig, pattern, exact), std::span(pixels));
  return pixels;
}

constexpr sim::ChessboardShape kChessboardShape{37, 3, 2.2};

sim::ChessboardScene board(const sim::PerturbedRig& actual, double bend_mm, double lean) {
  sim::ChessboardPlace place;
  place.middle = sim::middle_of_view(actual, actual.rig.plane_z_mm - 20);
  place.below = {std::cos(lean), 0, std::sin(lean)};
  return {actual.rig, kChessboardShape, place, sim::drawn_flaws(1e-4, bend_mm, 7)};
}

TEST(SmoothScenes, ImagesAreTheSameToTheLastBit) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const sim::PerturbedRig actual = low_image(seed);
    const sim::FlatPlate plate(20, {0.005, 0.01}, seed);
    EXPECT_EQ(image_of(actual, plate), image_of(actual, Silent(plate)));
    const sim::FlatPlate wavy(20, {0.005, 3}, seed);  // more than may be left out
    EXPECT_EQ(image_of(actual, wavy), image_of(actual, Silent(wavy)));
    for (const double bend : {0.0, 0.01, 0.5}) {
      const sim::ChessboardScene scene = board(actual, bend, bend);
      EXPECT_EQ(image_of(actual, scene), image_of(actual, Silent(scene))) << bend;
    }
  }
}

// A plain rectangle has one albedo, and the surface bends no more over one than is said.
TEST(SmoothScenes, ChessboardsTellTheTruth) {
  const sim::PerturbedRig actual = low_image(1);
  const sim::ChessboardScene scene = board(actual, 0.4, 0.3);
  const sim::Point3 middle = sim::middle_of_view(actual, actual.rig.plane_z_mm - 20);
  int plain = 0;
  int smooth = 0;
  constexpr double kSide = 0.6;  // mm
  for (double x = middle.x - 8; x < middle.x + 8; x += 0.31) {
    for (double y = middle.y - 48; y < middle.y + 48; y += 0.87) {
      const sim::Box box{x, x + kSide, y, y + kSide};
      double low = 1;
      double high = 0;
      for (int i = 0; i <= 6; ++i) {
        for (int j = 0; j <= 6; ++j) {
          const double albedo = scene.albedo(x + kSide * i / 6, y + kSide * j / 6, 0);
          low = std::min(low, albedo);
          high = std::max(high, albedo);
        }
      }
      const bool is_plain = scene.is_plain(box);
      EXPECT_TRUE(!is_plain || high - low < 1e-12) << x << ", " << y;
      plain += is_plain ? 1 : 0;
      const sim::Smoothness bounds = scene.smoothness(box);
      const auto height = [&](double share) { return scene.height(x + kSide * share, y + kSide * share, 0); };
      const double step = kSide * std::sqrt(2) / 2;
      EXPECT_LE(std::abs(height(1) - height(0)), bounds.slope * 2 * step);
      EXPECT_LE(std::abs(height(0) - 2 * height(0.5) + height(1)), bounds.curvature * step * step + 1e-12);
      smooth += bounds.curvature < 1 ? 1 : 0;
    }
  }
  EXPECT_GT(plain, 2000);
  EXPECT_LT(plain, 5000);
  EXPECT_GT(smooth, 3000);
}

TEST(SmoothScenes, PlatesTellTheTruth) {
  const sim::FlatPlate plate(20, {0.005, 0.5}, 3);
  const sim::Smoothness bounds = plate.smoothness({0, 1, 0, 1});
  constexpr double kStep = 2;  // mm
  for (double x = -60; x < 60; x += 1.7) {
    for (double y = -60; y < 60; y += 1.7) {
      const auto height = [&](int i) { return plate.height(x + kStep * i, y, 0); };
      EXPECT_LE(std::abs(height(1) - height(0)), bounds.slope * kStep);
      EXPECT_LE(std::abs(height(0) - 2 * height(1) + height(2)), bounds.curvature * kStep * kStep);
      EXPECT_LE(std::abs(height(3) - 3 * height(2) + 3 * height(1) - height(0)), bounds.change * kStep * kStep * kStep);
    }
  }
}

TEST(SightTable, IsTheCamera) {
  const sim::PerturbedRig actual = low_image(4);
  const auto table = sim::SightTable::of(actual.camera, actual.rig.camera);
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(sim::SightTable::of(actual.camera, actual.rig.camera), table) << "shared";
  EXPECT_NE(sim::SightTable::of(low_image(5).camera, actual.rig.camera), table);
  EXPECT_EQ(sim::SightTable::of(sim::Pinhole::of_camera(actual.rig.camera), actual.rig.camera), nullptr);
  for (const double row : {-30.0, -8.375, -7.875, -0.125, 0.0, 3.125, 3.2, 39.5, 40.875, 47.375, 47.875, 90.0}) {
    for (const double column : {-9.0, -7.875, 0.375, 17.0, 255.625, 511.875, 519.375, 519.5, 700.0}) {
      const sim::Point3 found = table->sight({row, column});
      const sim::Point3 wanted = actual.camera.sight({row, column});
      EXPECT_EQ(found.x, wanted.x) << row << ", " << column;
      EXPECT_EQ(found.y, wanted.y) << row << ", " << column;
      EXPECT_EQ(found.z, wanted.z) << row << ", " << column;
    }
  }
}

// Tests the scenes of rig B: what moves, where, and how fast.

constexpr double kCrater = 10;
constexpr double kSize = 12;

// Airy's theory with surface tension for water 30 mm deep, in mm and s.
double omega_of(double k) { return std::sqrt(k * (9800 + 72.9e3 * k * k) * std::tanh(30 * k)); }

// The integral of ring_wave.h by Simpson's rule, with steps far finer than the table's.
double wave_by_simpson(double r, double t) {
  constexpr int kSteps = 20000;
  constexpr double kLast = 7 / kSize;
  const auto f = [&](double k) {
    return k * k * k * std::exp(-k * k * kSize * kSize / 2) * ::j0(k * r) * std::cos(omega_of(k) * t);
  };
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double k = kLast * i / kSteps;
    sum += f(k) * (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2);
  }
  return -kCrater * std::pow(kSize, 4) / 2 * sum * kLast / kSteps / 3;
}

TEST(RingWave, IsTheIntegral) {
  const sim::RingWave wave(30, kCrater, kSize, 0.3);
  EXPECT_NEAR(wave.speed(), 542.2, 0.05);  // sqrt(9.8 m/s² · 3 cm)
  for (const double t : {0.0, 0.0203, 0.1, 0.299}) {
    const sim::RingWave::Profile profile = wave.profile(t);
    for (double r = 0; r < 220; r += 7.3) {
      EXPECT_NEAR(profile.at(r).rise, wave_by_simpson(r, t), 0.02) << "r " << r << ", t " << t;
      const double slope = (wave_by_simpson(r + 0.1, t) - wave_by_simpson(r - 0.1, t)) / 0.2;
      EXPECT_NEAR(r > 0 ? profile.at(r).slope : 0, r > 0 ? slope : 0, 0.02) << "r " << r << ", t " << t;
    }
  }
}

// What every book says of water waves: the slowest ripples of deep water are 17 mm long and run at 23 cm/s, waves much
// longer than the depth run at sqrt(g depth), and deep gravity waves at sqrt(g / k).
TEST(RingWave, WavelengthsRunAtTheirOwnSpeeds) {
  double slowest = 1e9;
  double length = 0;
  for (double l = 5; l < 60; l += 0.01) {
    const double k = 2 * std::numbers::pi / l;
    const double speed = sim::RingWave::omega(k, 1e4) / k;
    length = speed < slowest ? l : length;
    slowest = std::min(slowest, speed);
  }
  EXPECT_NEAR(slowest, 231, 1);
  EXPECT_NEAR(length, 17.1, 0.2);
  EXPECT_NEAR(sim::RingWave::omega(1e-4, 30) / 1e-4, 542.2, 0.1);
  EXPECT_NEAR(sim::RingWave::omega(2e-3, 1e4) / 2e-3, std::sqrt(9800 / 2e-3), 0.1);
}

// At first there is the requested crater. Its crests are shorter than the water is deep, and run at about half of the
// speed of long waves; nothing but long waves runs ahead of them.
TEST(RingWave, BeginsAsACraterAndDisperses) {
  const sim::RingWave wave(30, kCrater, kSize, 0.4);
  const sim::RingWave::Profile first = wave.profile(0);
  for (double r = 0; r < 80; r += 5) {
    const double u = r * r / (2 * kSize * kSize);
    EXPECT_NEAR(first.at(r).rise, -kCrater * (1 - u) * std::exp(-u), 0.02) << r;
  }
  EXPECT_EQ(wave.profile(-0.001).at(0).rise, 0);
  EXPECT_EQ(wave.profile(-0.001).reach(), 0);
  const auto crest = [&](double t) {
    const sim::RingWave::Profile profile = wave.profile(t);
    double best = 0;
    for (double r = 0; r < 400; r += 0.1) {
      best = profile.at(r).rise > profile.at(best).rise ? r : best;
    }
    return best;
  };
  const double crests = (crest(0.35) - crest(0.15)) / 0.2;
  EXPECT_GT(crests, 0.25 * wave.speed());
  EXPECT_LT(crests, 0.75 * wave.speed());
  EXPECT_GE(wave.most(), kCrater - 0.1);
  EXPECT_THROW(sim::RingWave(0, 1, 1, 1), std::invalid_argument);
}

// Where a pixel's ray meets the bodies of a scene.
std::optional<sim::Meeting> seen(const sim::Scene& scene, const rig::Rig& rig, double row, double column, double t) {
  const sim::Point3 along = sim::Pinhole::of_camera(rig.camera).ray({row, column});
  std::optional<sim::Meeting> nearest;
  for (const auto& body : scene.bodies(t)) {
    sim::Meeting meeting;
    if (body->meets({{0, 0, 0}, along}, nearest ? nearest->s : 1e9, meeting)) {
      nearest = meeting;
    }
  }
  return nearest;
}

TEST(Waves, WaterIsLevelBeforeTheImpactAndKeepsToItsWallsAfter) {
  const rig::Rig rig = rig::load_rig("scanner");
  const auto scene = sim::make_scene("waves", rig);
  const double level = rig.plane_z_mm - sim::PoolWave::kDepth;
  // The body hangs above the place of the impact, and touches the water at 1.36 s.
  const auto bottom = [&](double t) { return scene->bodies(t)[1]->bounds().high.z; };
  EXPECT_NEAR(bottom(0), level - 100, 1e-9);
  EXPECT_NEAR(bottom(sim::PoolWave::kImpact), level, 1e-9);
  EXPECT_GT(bottom(sim::PoolWave::kImpact + 0.1), level + 11);
  const sim::Bodies before = scene->bodies(sim::PoolWave::kImpact - 1e-3);
  const sim::Bodies after = scene->bodies(sim::PoolWave::kImpact + 0.28);
  double most = 0;
  for (double x = sim::PoolWave::kCentreX - 124.5; x < sim::PoolWave::kCentreX + 125; x += 3.1) {
    for (const double y : {-169.9, -120.0, -60.0, 20.0, 100.0, 169.9}) {
      const sim::Ray down{{x, y, 0}, {0, 0, 1}};
      sim::Meeting meeting;
      ASSERT_TRUE(before[0]->meets(down, 1000, meeting));
      EXPECT_NEAR(meeting.s, level, 1e-9);
      EXPECT_NEAR(meeting.normal.z, -1, 1e-12);
      ASSERT_TRUE(after[0]->meets(down, 1000, meeting));
      most = std::max(most, std::abs(meeting.s - level));
      // The water cannot pass through the walls, so it is level along their normals.
      if (std::abs(y) > 169) {
        EXPECT_NEAR(meeting.normal.y, 0, 0.003);
      }
    }
  }
  EXPECT_GT(most, 1);
  EXPECT_LT(most, 8);
  sim::Meeting meeting;
  EXPECT_FALSE(before[0]->meets({{sim::PoolWave::kCentreX + 126, 0, 0}, {0, 0, 1}}, 1000, meeting));
}

TEST(Fist, GoesRoundASlantedCircle) {
  const rig::Rig rig = rig::load_rig("scanner");
  const auto scene = sim::make_scene("fist", rig);
  const auto centre = [&](double t) {
    const sim::Cuboid box = scene->bodies(t)[0]->bounds();
    return 0.5 * (box.low + box.high);
  };
  const double turn = 1 / sim::FistMotion::kFrequency;
  const sim::Point3 middle = 0.5 * (centre(0) + centre(turn / 2));
  double low = 1e9;
  double high = 0;
  for (int i = 0; i < 50; ++i) {
    const double t = turn * i / 50;
    const sim::Point3 d = centre(t) - middle;
    EXPECT_NEAR(std::sqrt(sim::dot(d, d)), sim::FistMotion::kRadius, 1e-9);
    const sim::Point3 later = centre(t + turn) - centre(t);
    EXPECT_NEAR(sim::dot(later, later), 0, 1e-12);
    const double height = rig.plane_z_mm - centre(t).z;
    low = std::min(low, height);
    high = std::max(high, height);
    const sim::Point3 way = centre(t + 1e-6) - centre(t);
    EXPECT_LE(std::sqrt(sim::dot(way, way)) / 1e-6, scene->body_speed() * 1.0001);
  }
  EXPECT_NEAR(low, 80, 0.5);  // its upper side, which the camera sees, is at 100 to 200 mm
  EXPECT_NEAR(high, 180, 0.5);
}

TEST(Keys, TwoPixelsSeeFingersThatTapByTurns) {
  const rig::Rig rig = rig::load_rig("scanner");
  const auto scene = sim::make_scene("keys", rig);
  for (const sim::KeyTaps::Pixel pixel : {sim::KeyTaps::kFirst, sim::KeyTaps::kSecond}) {
    double low = 1e9;
    double high = 0;
    double when = 0;  // furthest from the camera: down
    for (int i = 0; i < 200; ++i) {
      const auto meeting = seen(*scene, rig, pixel.row, pixel.column, i * 1e-3);
      ASSERT_TRUE(meeting);
      low = std::min(low, meeting->s);
      if (meeting->s > high) {
        high = meeting->s;
        when = i * 1e-3;
      }
      EXPECT_NEAR(seen(*scene, rig, pixel.row, pixel.column, i * 1e-3 + 0.2)->s, meeting->s, 1e-6);
    }
    EXPECT_NEAR(high - low, sim::KeyTaps::kStroke, 0.5);
    EXPECT_NEAR(std::fmod(when + 0.05, 0.2), pixel.row == sim::KeyTaps::kFirst.row ? 0.05 : 0.15, 0.003);
  }
  // The keys go down under them by 3.5 mm.
  for (const std::size_t key : {0U, 1U}) {
    const auto top = [&](double t) { return rig.plane_z_mm - scene->bodies(t)[key]->bounds().low.z; };
    EXPECT_NEAR(top(key == 0 ? 0.0 : 0.1), 26.5, 1e-9);
    EXPECT_NEAR(top(key == 0 ? 0.1 : 0.0), 30, 1e-9);
  }
  // 18 mm apart along both axes
  const sim::Bodies bodies = scene->bodies(0);
  const sim::Point3 apart = bodies[0]->bounds().low - bodies[1]->bounds().low;
  EXPECT_NEAR(std::abs(apart.x), 18, 1e-9);
  EXPECT_NEAR(std::abs(apart.y), 18, 1e-9);
}

}  // namespace
}  // namespace selfproj::test
