// Tests scenes and how rays meet them, pinholes, and projected light.

#include "sim/scene/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "host/light_section/pattern.h"
#include "host/rig/rig.h"
#include "sim/scene/height_map.h"
#include "sim/scene/marks.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/ray.h"
#include "sim/scene/scene_info.h"
#include "sim/scene/scene_list.h"
#include "tests/support/error_of.h"
#include "tests/support/random_cases.h"

namespace selfproj {
namespace {

using test::error_of;
using test::how_to_repeat;
using test::Random;
using test::seeds;

// Rough terrain with cliffs, 40 rows x 30 columns.
FloatImage random_map(Random& random) {
  FloatImage map(40, 30);
  for (float& value : map.values) {
    value = random.chance(30) ? 30 : static_cast<float>(random.between(0, 100)) / 10;
  }
  return map;
}

std::vector<std::unique_ptr<Scene>> all_scenes(const Rig& rig, Random& random) {
  std::vector<std::unique_ptr<Scene>> all;
  for (const SceneInfo& info : scenes()) {
    all.push_back(make_scene(info.name, load_rig(info.rig())));
  }
  all.push_back(height_map_scene(random_map(random), 2.5, rig));
  return all;
}

// ------------------------------------------------------------------ scenes

TEST(Scene, ListedOnesExistAndNameTheirReference) {
  ASSERT_EQ(scenes().size(), 16U);
  for (const SceneInfo& info : scenes()) {
    const Rig rig = load_rig(info.rig());
    EXPECT_EQ(make_scene(info.name, rig)->frames(), info.frames);
    const SceneInfo& reference = find_scene(info.reference_name());
    EXPECT_EQ(reference.method, info.method) << info.name;
    EXPECT_EQ(reference.cells_below, info.cells_below) << info.name;
    EXPECT_TRUE(reference.reference.empty()) << info.name << ": a reference has no reference of its own";
  }
  EXPECT_EQ(scenes()[3].name, "stairs-marked");
  EXPECT_EQ(scenes()[3].reference, "stairs");
  EXPECT_EQ(scenes()[3].frames, 1400);
  EXPECT_EQ(error_of([] { make_scene("fist", load_rig("light-section")); }),
            "fist: needs a rig of kind scanner; light-section is not one");
}

// The part reaches x = 0 5 mm after the first frame, and has passed by 5 mm at the last.
TEST(Scene, PartsPassAtTheSpeedOfTheConveyor) {
  const Rig rig = load_rig("light-section");
  const auto stairs = make_scene("stairs", rig);
  const auto at = [&](double millimetres) { return stairs->height(0, 0, millimetres / rig.conveyor.speed_mm_per_s); };
  EXPECT_EQ(at(0), 0);
  EXPECT_EQ(at(4.99), 0);
  EXPECT_EQ(at(5.01), 39);
  EXPECT_EQ(at(134.99), 39);
  EXPECT_EQ(at(135.01), 0);
  EXPECT_EQ(stairs->speed(), 1000);
}

TEST(Scene, HeightsAreThoseOfTheExperiments) {
  const Rig rig = load_rig("light-section");
  const double t = 0.07;  // the middle of the part is at x = 0
  const auto mountain = make_scene("mountain", rig);
  EXPECT_NEAR(mountain->height(0, 0, t), 23.6, 1e-9);
  EXPECT_NEAR(mountain->height(30, 49.99, t), 0, 1e-4);
  EXPECT_NEAR(mountain->height(30, 25, t), 23.6 * 0.5625, 1e-9);
  EXPECT_EQ(mountain->height(0, 50.01, t), 0);
  const auto stairs = make_scene("stairs", rig);
  EXPECT_EQ(stairs->height(0, -52.4, t), 30);
  EXPECT_EQ(stairs->height(0, -17.6, t), 30);
  EXPECT_EQ(stairs->height(0, -17.4, t), 39);
  EXPECT_EQ(stairs->height(0, 17.4, t), 39);
  EXPECT_EQ(stairs->height(0, 17.6, t), 21);
  EXPECT_EQ(stairs->height(0, 52.4, t), 21);
  EXPECT_EQ(stairs->height(0, 52.6, t), 0);
  const auto marked = make_scene("stairs-marked", rig);
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
  for (const Mark mark : {Mark::circle, Mark::cross, Mark::triangle_down}) {
    double left = 0;
    double right = 0;
    double up = 0;
    double down = 0;
    double area = 0;
    for (double r = -kHalf; r < kHalf; r += kStep) {
      for (double d = -kHalf; d < kHalf; d += kStep) {
        if (distance_from_mark(mark, r, d) <= kMarkStroke / 2) {
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
    const double expected = mark == Mark::circle  ? M_PI * (11.0 * 11 - 8.0 * 8)
                            : mark == Mark::cross ? 2 * bar + 4 * half_circle - 9
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
    const Rig rig = load_rig("light-section");
    for (const auto& scene : all_scenes(rig, random)) {
      for (int i = 0; i < 50; ++i) {
        const double t = uniform(random, 0, 0.14);
        const double size = std::pow(10, uniform(random, -4, 2));
        const double x = uniform(random, -80, 80);
        const double y = uniform(random, -65, 65);
        const Box box{x, x + uniform(random, 0, size), y, y + uniform(random, 0, size)};
        const double t1 = t + uniform(random, 0, 1e-4);
        const HeightRange range = scene->range(box, t, t1);
        for (int k = 0; k < 30; ++k) {
          const double h =
              scene->height(uniform(random, box.x0, box.x1), uniform(random, box.y0, box.y1), uniform(random, t, t1));
          EXPECT_GE(h, range.low);
          EXPECT_LE(h, range.high);
        }
        const HeightRange point = scene->range({x, x, y, y}, t, t);
        EXPECT_NEAR(point.low, point.high, 1e-9);
      }
    }
  }
}

TEST(Scene, HeightMapLiesAsHeightsAreMeasured) {
  Rig rig = load_rig("light-section");
  FloatImage map(2, 3);
  map.values = {1, 2, 3, 4, std::numeric_limits<float>::quiet_NaN(), 6};
  const auto scene = height_map_scene(map, 10, rig);
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
  EXPECT_EQ(height_map_scene(map, 10, rig)->frames(), 1);
  EXPECT_NEAR(height_map_scene(map, 10, rig)->height(5, -10, 7), 1, 1e-6);
}

TEST(Scene, ErrorsNameWhatIsWrong) {
  const Rig rig = load_rig("light-section");
  EXPECT_EQ(error_of([&] { make_scene("hill", rig); }),
            "hill: is not a scene; the scenes are plane, mountain, stairs, stairs-marked, desk, fist, pool, waves, "
            "keyboard, keys, cuboids, cuboids-marked, slider, mouse, "
            "block, hands");
  EXPECT_EQ(error_of([&] { height_map_scene({}, 1, rig, "a.tiff"); }), "a.tiff: has no pixels");
  const FloatImage map(2, 2, 1);
  for (const double scale : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(error_of([&] { height_map_scene(map, scale, rig); }).find("must be greater than 0"), std::string::npos);
  }
  EXPECT_NE(error_of([&] { height_map_scene(FloatImage(2, 2, 588), 1, rig); }).find("must be finite and below 588"),
            std::string::npos);
  EXPECT_NE(error_of([&] { height_map_scene(FloatImage(2, 2, INFINITY), 1, rig); }).find("must be finite"),
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
    const Rig rig = load_rig("light-section");
    for (const auto& scene : all_scenes(rig, random)) {
      for (int i = 0; i < 20; ++i) {
        const double t = uniform(random, 0, 0.14);
        const HeightRay ray{uniform(random, -40, 40), uniform(random, -1, 1), uniform(random, -60, 60),
                            uniform(random, -1, 1)};
        const auto clearance = [&](double h) { return h - scene->height(ray.x + ray.dx * h, ray.y + ray.dy * h, t); };
        double expected = kTop;
        while (expected > 0 && clearance(expected) > 0) {
          expected -= kStep;
        }
        const double found = first_hit(*scene, ray, t, 0, kTop);
        // Steps may miss an edge that the ray only just touches. Then it must be one.
        if (std::abs(found - expected) > 2 * kStep) {
          EXPECT_GT(found, expected);
          EXPECT_LE(clearance(found - 2 * kHeightTolerance), 2 * kStep);
        }
        const double from = uniform(random, 0, kTop);
        bool blocked = false;
        for (double h = from; h <= kTop; h += kStep) {
          blocked = blocked || clearance(h) < 0;
        }
        if (blocked) {
          EXPECT_TRUE(is_blocked(*scene, ray, t, from, kTop));
        } else if (is_blocked(*scene, ray, t, from, kTop)) {
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
  const RigCamera rig = load_rig("light-section").camera;
  const Pinhole camera = Pinhole::of_camera(rig);
  const PixelPoint p = camera.project({11.67, -23.34, 1167});
  EXPECT_NEAR(p.row, 47.5 + 0.01 / 0.01 * 50, 1e-9);  // Xc = fc x / z = 0.5 mm, a pitch of 0.01 mm
  EXPECT_NEAR(p.column, 255.5 - 0.02 / 0.01 * 50, 1e-9);
}

// θ = θ0 + atan(Xp/fp) is measured from z towards −x, and y = (z − z0) Yp / (fp cos θ0 − Xp sin θ0).
TEST(Pinhole, ProjectorIsThatOf36To38) {
  for (const std::string& name : built_in_rigs()) {
    const RigProjector rig = load_rig(name).projector;
    const Pinhole projector = Pinhole::of_projector(rig);
    Random random(1);
    for (int i = 0; i < 100; ++i) {
      const Point3 p{uniform(random, -100, 50), uniform(random, -100, 100), rig.z_mm + uniform(random, 100, 600)};
      const PixelPoint found = projector.project(p);
      const double xp = rig.center_xp_mm + rig.line_pitch_mm * (found.row - (rig.lines - 1) / 2.0);
      const double yp = rig.center_yp_mm + rig.column_pitch_mm * (found.column - (rig.columns - 1) / 2.0);
      const double theta = rig.tilt_rad + std::atan(xp / rig.focal_length_mm);
      EXPECT_NEAR(std::tan(theta), (rig.x_mm - p.x) / (p.z - rig.z_mm), 1e-9);
      EXPECT_NEAR((p.z - rig.z_mm) * yp / (rig.focal_length_mm * std::cos(rig.tilt_rad) - xp * std::sin(rig.tilt_rad)),
                  p.y, 1e-9);
      // and back
      const Point3 along = projector.ray(found);
      const Point3 again = projector.centre() + projector.depth(p) * along;
      EXPECT_NEAR(again.x, p.x, 1e-9);
      EXPECT_NEAR(again.y, p.y, 1e-9);
      EXPECT_NEAR(again.z, p.z, 1e-9);
    }
  }
}

// ------------------------------------------------------------------ projected light

TEST(ProjectedLight, StraightLineHasItsWidthAndPlace) {
  const Rig all = load_rig("light-section");
  const RigProjector& rig = all.projector;
  for (const double place : {100.0, 100.3, 100.5, 100.9}) {
    const FloatImage pattern = draw_straight_line(all, place);
    double m0 = 0;
    double m1 = 0;
    for (int r = 0; r < rig.lines; ++r) {
      m0 += static_cast<double>(pattern.row(r)[17]);
      m1 += static_cast<double>(pattern.row(r)[17]) * r;
    }
    EXPECT_NEAR(m0, 5, 1e-5);
    EXPECT_NEAR(m1 / m0, place, 1e-5);
    const ProjectedLight light(pattern, 0.7);
    EXPECT_NEAR(light.line_centre(17.4), place, 1e-5);
  }
  EXPECT_TRUE(std::isnan(ProjectedLight(FloatImage(4, 4), 0).line_centre(1)));
}

TEST(ProjectedLight, BlurKeepsSumAndMiddleAndWidens) {
  FloatImage pattern(40, 50);
  pattern.row(20)[30] = 1;
  for (const double blur : {0.0, 0.4, 0.7, 2.0}) {
    const ProjectedLight light(pattern, blur);
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

}  // namespace
}  // namespace selfproj
