// Tests the scenes of rig B: what moves, where, and how fast.

#include "sim/scene/scanner_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/body.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/ring_wave.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"

namespace selfproj {
namespace {

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
  const RingWave wave(30, kCrater, kSize, 0.3);
  EXPECT_NEAR(wave.speed(), 542.2, 0.05);  // sqrt(9.8 m/s² · 3 cm)
  for (const double t : {0.0, 0.0203, 0.1, 0.299}) {
    const RingWave::Profile profile = wave.profile(t);
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
    const double speed = RingWave::omega(k, 1e4) / k;
    length = speed < slowest ? l : length;
    slowest = std::min(slowest, speed);
  }
  EXPECT_NEAR(slowest, 231, 1);
  EXPECT_NEAR(length, 17.1, 0.2);
  EXPECT_NEAR(RingWave::omega(1e-4, 30) / 1e-4, 542.2, 0.1);
  EXPECT_NEAR(RingWave::omega(2e-3, 1e4) / 2e-3, std::sqrt(9800 / 2e-3), 0.1);
}

// At first there is the requested crater. Its crests are shorter than the water is deep, and run at about half of the
// speed of long waves; nothing but long waves runs ahead of them.
TEST(RingWave, BeginsAsACraterAndDisperses) {
  const RingWave wave(30, kCrater, kSize, 0.4);
  const RingWave::Profile first = wave.profile(0);
  for (double r = 0; r < 80; r += 5) {
    const double u = r * r / (2 * kSize * kSize);
    EXPECT_NEAR(first.at(r).rise, -kCrater * (1 - u) * std::exp(-u), 0.02) << r;
  }
  EXPECT_EQ(wave.profile(-0.001).at(0).rise, 0);
  EXPECT_EQ(wave.profile(-0.001).reach(), 0);
  const auto crest = [&](double t) {
    const RingWave::Profile profile = wave.profile(t);
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
  EXPECT_THROW(RingWave(0, 1, 1, 1), std::invalid_argument);
}

// Where a pixel's ray meets the bodies of a scene.
std::optional<Meeting> seen(const Scene& scene, const Rig& rig, double row, double column, double t) {
  const Point3 along = Pinhole::of_camera(rig.camera).ray({row, column});
  std::optional<Meeting> nearest;
  for (const auto& body : scene.bodies(t)) {
    Meeting meeting;
    if (body->meets({{0, 0, 0}, along}, nearest ? nearest->s : 1e9, meeting)) {
      nearest = meeting;
    }
  }
  return nearest;
}

TEST(Waves, WaterIsLevelBeforeTheImpactAndKeepsToItsWallsAfter) {
  const Rig rig = load_rig("scanner");
  const auto scene = make_scene("waves", rig);
  const double level = rig.plane_z_mm - PoolWave::kDepth;
  // The body hangs above the place of the impact, and touches the water at 1.36 s.
  const auto bottom = [&](double t) { return scene->bodies(t)[1]->bounds().high.z; };
  EXPECT_NEAR(bottom(0), level - 100, 1e-9);
  EXPECT_NEAR(bottom(PoolWave::kImpact), level, 1e-9);
  EXPECT_GT(bottom(PoolWave::kImpact + 0.1), level + 11);
  const Bodies before = scene->bodies(PoolWave::kImpact - 1e-3);
  const Bodies after = scene->bodies(PoolWave::kImpact + 0.28);
  double most = 0;
  for (double x = PoolWave::kCentreX - 124.5; x < PoolWave::kCentreX + 125; x += 3.1) {
    for (const double y : {-169.9, -120.0, -60.0, 20.0, 100.0, 169.9}) {
      const Ray down{{x, y, 0}, {0, 0, 1}};
      Meeting meeting;
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
  Meeting meeting;
  EXPECT_FALSE(before[0]->meets({{PoolWave::kCentreX + 126, 0, 0}, {0, 0, 1}}, 1000, meeting));
}

TEST(Fist, GoesRoundASlantedCircle) {
  const Rig rig = load_rig("scanner");
  const auto scene = make_scene("fist", rig);
  const auto centre = [&](double t) {
    const Cuboid box = scene->bodies(t)[0]->bounds();
    return 0.5 * (box.low + box.high);
  };
  const double turn = 1 / FistMotion::kFrequency;
  const Point3 middle = 0.5 * (centre(0) + centre(turn / 2));
  double low = 1e9;
  double high = 0;
  for (int i = 0; i < 50; ++i) {
    const double t = turn * i / 50;
    const Point3 d = centre(t) - middle;
    EXPECT_NEAR(std::sqrt(dot(d, d)), FistMotion::kRadius, 1e-9);
    const Point3 later = centre(t + turn) - centre(t);
    EXPECT_NEAR(dot(later, later), 0, 1e-12);
    const double height = rig.plane_z_mm - centre(t).z;
    low = std::min(low, height);
    high = std::max(high, height);
    const Point3 way = centre(t + 1e-6) - centre(t);
    EXPECT_LE(std::sqrt(dot(way, way)) / 1e-6, scene->body_speed() * 1.0001);
  }
  EXPECT_NEAR(low, 80, 0.5);  // its upper side, which the camera sees, is at 100 to 200 mm
  EXPECT_NEAR(high, 180, 0.5);
}

// Drawn paths differ, are circles of their size and slant, and the camera sees all of the fist on them.
TEST(Fist, DrawnPathsAreSeen) {
  const Rig rig = load_rig("scanner");
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const FistPath path = drawn_path(seed);
    EXPECT_NE(path.radius, drawn_path(seed + 1).radius);
    EXPECT_LT(path.rise, path.radius);
    const auto scene = make_fist(rig, path);
    double high = 0;
    for (int i = 0; i < 40; ++i) {
      const Cuboid box = scene->bodies(i / (40 * path.frequency))[0]->bounds();
      const Point3 c = 0.5 * (box.low + box.high);
      EXPECT_NEAR(std::hypot(c.x - path.x, c.y - path.y, rig.plane_z_mm - path.height - c.z), path.radius, 1e-9);
      high = std::max(high, rig.plane_z_mm - path.height - c.z);
      for (const Point3 corner : {box.low, box.high}) {
        const PixelPoint at = Pinhole::of_camera(rig.camera).project({corner.x, corner.y, box.low.z});
        EXPECT_GE(std::min(at.row, at.column), 0) << "seed " << seed;
        EXPECT_LE(at.column, rig.camera.columns - 1) << "seed " << seed;
        EXPECT_LE(at.row, 440) << "seed " << seed << ": a projector line is worth too much there";
      }
    }
    EXPECT_NEAR(high, path.rise, 0.01 * path.rise);
  }
}

TEST(Keys, TwoPixelsSeeFingersThatTapByTurns) {
  const Rig rig = load_rig("scanner");
  const auto scene = make_scene("keys", rig);
  for (const KeyTaps::Pixel pixel : {KeyTaps::kFirst, KeyTaps::kSecond}) {
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
    EXPECT_NEAR(high - low, KeyTaps::kStroke, 0.5);
    EXPECT_NEAR(std::fmod(when + 0.05, 0.2), pixel.row == KeyTaps::kFirst.row ? 0.05 : 0.15, 0.003);
  }
  // The keys go down under them by 3.5 mm.
  for (const std::size_t key : {0U, 1U}) {
    const auto top = [&](double t) { return rig.plane_z_mm - scene->bodies(t)[key]->bounds().low.z; };
    EXPECT_NEAR(top(key == 0 ? 0.0 : 0.1), 26.5, 1e-9);
    EXPECT_NEAR(top(key == 0 ? 0.1 : 0.0), 30, 1e-9);
  }
  // 18 mm apart along both axes
  const Bodies bodies = scene->bodies(0);
  const Point3 apart = bodies[0]->bounds().low - bodies[1]->bounds().low;
  EXPECT_NEAR(std::abs(apart.x), 18, 1e-9);
  EXPECT_NEAR(std::abs(apart.y), 18, 1e-9);
}

}  // namespace
}  // namespace selfproj
