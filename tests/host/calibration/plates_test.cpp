// Tests chessboards on plates over a belt in a world of narrow view, whose free poses would leave the lens open: the
// rays of the camera and the light of the projector over the belt, the way of the belt, and what is refused.
#include "host/calibration/plates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/calibrate.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "tests/support/chessboard_world.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

constexpr std::array<double, 4> kHeights{0, 20, 40, 60};
constexpr std::array<double, 2> kMoves{0, 6};

// How plates lie over the belt, in its axes: x across it, y along it, z away from the camera.
struct Placing {
  double height = 0;
  double x = 0, y = 0;
  double turn_deg = 0, lean_deg = 0;
  double bulge = 0;  // of the chessboard's middle over its ends
};

// A light section much like rig A, leaning over its belt.
class NarrowWorld {
 public:
  NarrowWorld() {
    world.camera = {5030, 5030, 262, 41, 0.06};
    world.projector = {2830, 3240, 251, 890};
    world.rotation = test::turn(-20.4, -0.7, -0.3);
    world.translation = {-2, -530, -421};
    world.camera_columns = 512;
    world.camera_rows = 96;
    world.projector_columns = world.projector_rows = 512;
    world.chessboard_columns = 19;
    world.chessboard_rows = 3;
    world.square = 4.4;
  }

  // x_camera = belt (x, y, z) + over.
  [[nodiscard]] cv::Vec3d in_camera_axes(const cv::Vec3d& on_belt) const { return belt * on_belt + over; }

  // What is observed of these plates, the belt at each of its places.
  [[nodiscard]] std::vector<calibration::PoseReport> observed(const std::vector<Placing>& plates) const {
    constexpr double kCameraNoisePx = 0.005;
    constexpr double kProjectorNoisePx = 0.1;
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    std::vector<calibration::PoseReport> reports;
    for (const Placing& plate : plates) {
      for (const double move : kMoves) {
        calibration::PoseReport report;
        report.name = "pose" + std::to_string(reports.size());
        report.rows = world.camera_rows;
        report.columns = world.camera_columns;
        const cv::Vec3d middle(0.5 * world.square * (world.chessboard_columns - 1), world.square, 0);
        for (int i = 0; i < world.chessboard_columns * world.chessboard_rows; ++i) {
          cv::Vec3d on_plate = world.on_chessboard(i) - middle;
          on_plate[2] = -plate.bulge * (1 - std::pow(on_plate[0] / middle[0], 2));
          const cv::Vec3d lying =
              test::turn(0, plate.lean_deg, plate.turn_deg) * on_plate +
              cv::Vec3d(plate.x + way[0] * (move - 3), plate.y + way[1] * (move - 3), -plate.height);
          const cv::Vec3d at = in_camera_axes(lying);
          const auto noisy = [&](const cv::Vec2d& seen, double noise) {
            const double x = seen[0] + noise * normal(random);
            return cv::Point2d(x, seen[1] + noise * normal(random));
          };
          calibration::Corner corner;
          corner.camera = noisy(world.in_camera(at), kCameraNoisePx);
          corner.projector = noisy(world.in_projector(at), kProjectorNoisePx);
          corner.used = true;
          report.corners.push_back(corner);
        }
        reports.push_back(report);
      }
    }
    return reports;
  }

  // The drawings: focal lengths, centres and tilt are a little off.
  [[nodiscard]] calibration::CalibrateSettings settings() const {
    calibration::CalibrateSettings settings;
    settings.chessboard = {world.chessboard_columns, world.chessboard_rows, world.square};
    settings.projector_columns = world.projector_columns;
    settings.projector_rows = world.projector_rows;
    settings.bent = false;
    settings.plates.emplace(std::vector<double>(kHeights.begin(), kHeights.end()),
                            std::vector<double>(kMoves.begin(), kMoves.end()), calibration::PlateTolerance{},
                            world.square * (world.chessboard_columns - 1));
    settings.plates->camera = {5000, 5000, 255.5, 47.5};
    settings.plates->projector = {2849, 3257, 255.5, 876};
    settings.plates->stereo = {{-0.349, 0, 0}, {0, -529, -424}};
    settings.plates->scale = {.distance_mm = 1167, .min_focal_px = 5000, .max_focal_px = 5220};
    return settings;
  }

  World world;
  cv::Matx33d belt = test::turn(0.4, -0.3, 0.5);
  cv::Vec3d over{3, -2, 1168};
  cv::Vec2d way{std::sin(0.007), std::cos(0.007)};
};

// As a user puts them down: a little beside their heights and places.
std::vector<Placing> put_down() {
  return {{0.002, 0.02, -0.03, 0.01, 0.003},
          {19.998, -0.03, 0.02, -0.015, -0.002},
          {40.003, 0.03, 0.03, 0.005, 0.001},
          {59.997, -0.02, -0.02, 0.01, -0.003}};
}

// Where a pixel sees the plane at this height, on the belt's axes, by the truth and by what was found.
cv::Vec2d seen_on_belt(const cv::Vec3d& ray, const cv::Vec3d& along, const cv::Vec3d& normal, double distance) {
  const cv::Vec3d at = ray * (distance / normal.dot(ray));
  return {normal.cross(along).dot(at), along.dot(at)};
}

TEST(Plates, TellRaysLightAndBelt) {
  const NarrowWorld narrow;
  const calibration::CalibrationReport report = calibration::calibrate(narrow.observed(put_down()), narrow.settings());
  EXPECT_EQ(report.model.refusal, "");
  ASSERT_TRUE(report.belt);
  const std::array<double, 3>& n = report.belt->pose.normal;
  const std::array<double, 3>& d = report.belt->pose.direction;
  const cv::Vec3d normal(n[0], n[1], n[2]);
  const cv::Vec3d along(d[0], d[1], d[2]);
  EXPECT_NEAR(report.belt->way, 1, 1e-3);
  EXPECT_NEAR(report.belt->squares, 1, 1e-4);
  const cv::Vec3d true_normal(narrow.belt(0, 2), narrow.belt(1, 2), narrow.belt(2, 2));
  const cv::Vec3d true_along = narrow.belt * cv::Vec3d(narrow.way[0], narrow.way[1], 0);
  const rig::Calibration& c = report.calibration;
  std::vector<cv::Vec2d> off;
  for (const double height : {0.0, 21.0, 39.0, 60.0}) {
    for (const double column : {15.0, 150.0, 256.0, 380.0, 497.0}) {
      for (const double row : {0.0, 48.0, 95.0}) {
        // The true ray by fixed points of the lens.
        const WorldLens& lens = narrow.world.camera;
        cv::Vec3d ray((column - lens.cx) / lens.fx, (row - lens.cy) / lens.fy, 1);
        for (int i = 0; i < 20; ++i) {
          const cv::Vec2d at = lens.pixel(ray);
          ray += cv::Vec3d((column - at[0]) / lens.fx, (row - at[1]) / lens.fy, 0);
        }
        const double distance = true_normal.dot(narrow.over) - height;
        const std::optional<cv::Vec2d> found = c.camera.ray({column, row});
        ASSERT_TRUE(found);
        off.push_back(seen_on_belt({(*found)[0], (*found)[1], 1}, along, normal, report.belt->plane_z_mm - height) -
                      seen_on_belt(ray, true_along, true_normal, distance));
        // The projector's place of the same point.
        const cv::Vec3d truth = ray * (distance / true_normal.dot(ray));
        const cv::Vec3d mine =
            cv::Vec3d((*found)[0], (*found)[1], 1) *
            ((report.belt->plane_z_mm - height) / normal.dot(cv::Vec3d((*found)[0], (*found)[1], 1)));
        const cv::Vec3d in_projector = c.rotation * mine + c.translation;
        const cv::Vec2d lit = c.projector.pixel({in_projector[0] / in_projector[2], in_projector[1] / in_projector[2]});
        EXPECT_LT(cv::norm(lit - narrow.world.in_projector(truth)), 0.5) << height << ' ' << column << ' ' << row;
      }
    }
  }
  cv::Vec2d mean(0, 0);
  for (const cv::Vec2d& o : off) {
    mean += o / static_cast<double>(off.size());
  }
  for (const cv::Vec2d& o : off) {
    EXPECT_LT(cv::norm(o - mean), 0.06);  // the fence leaves 0.03 mm of 60 mm of height
  }

  // The rig says what of it was measured.
  using rig::ValueSource;
  rig::Rig drawn = rig::load_rig("light-section");
  const rig::Rig found = calibration::calibrated_rig(report, drawn);
  ASSERT_TRUE(found.sources);
  EXPECT_EQ(found.sources->camera, ValueSource::measured);
  EXPECT_EQ(found.sources->light, ValueSource::measured);
  EXPECT_EQ(found.sources->belt, ValueSource::measured);
  EXPECT_EQ(found.sources->encoder, ValueSource::measured);
  EXPECT_EQ(found.sources->speed, ValueSource::drawing);
  calibration::CalibrationReport held = report;
  held.belt.reset();
  drawn.sources = rig::RigSources{.speed = ValueSource::assumed};
  const rig::Rig by_hand = calibration::calibrated_rig(held, drawn);
  ASSERT_TRUE(by_hand.sources);
  EXPECT_EQ(by_hand.sources->light, ValueSource::measured);
  EXPECT_EQ(by_hand.sources->belt, ValueSource::drawing);
  EXPECT_EQ(by_hand.sources->encoder, ValueSource::drawing);
  EXPECT_EQ(by_hand.sources->speed, ValueSource::assumed);
  drawn.sources.reset();
  drawn.kind = rig::RigKind::scanner;
  EXPECT_FALSE(calibration::calibrated_rig(held, drawn).sources);
}

// What is said of these plates, the belt and its places said to be as `change` leaves them.
std::string said_of(const std::vector<Placing>& plates, const std::function<void(calibration::Plates&)>& change = {}) {
  const NarrowWorld narrow;
  calibration::CalibrateSettings settings = narrow.settings();
  settings.free = {0, 0};
  if (plates.size() < kHeights.size()) {
    const std::vector<double> heights(kHeights.begin(), kHeights.begin() + static_cast<std::ptrdiff_t>(plates.size()));
    const calibration::Plates all = *settings.plates;
    settings.plates.emplace(heights, std::vector<double>(kMoves.begin(), kMoves.end()), calibration::PlateTolerance{},
                            79.2);
    settings.plates->camera = all.camera;
    settings.plates->projector = all.projector;
    settings.plates->stereo = all.stereo;
    settings.plates->scale = all.scale;
  }
  if (change) {
    change(*settings.plates);
  }
  return test::error_of([&] { calibration::calibrate(narrow.observed(plates), settings); });
}

void expect_said(const std::string& said, const std::string& what) {
  EXPECT_NE(said.find(what), std::string::npos) << said << "\ninstead of: " << what;
}

TEST(Plates, WrongPlacesAreRefused) {
  std::vector<Placing> plates = put_down();
  std::swap(plates[1], plates[2]);
  expect_said(said_of(plates), "--plates: more than one plate lies higher or lower than said; the order of the poses");
  plates = put_down();
  plates[2].y += 1;
  const std::string beside = said_of(plates);
  expect_said(beside, "--plates: the plate at 40 mm lies 1.");
  expect_said(beside, "mm beside the others");
  const auto too_far = [](calibration::Plates& all) {
    for (calibration::PlatePlace& place : all.places) {
      place.belt_mm *= 1.1;
    }
  };
  expect_said(said_of(put_down(), too_far), "a millimetre of the belt moves the chessboard by 0.909");
}

// A plate that is off bends the line through all of them, most of all at its neighbour if it is the first or the last.
TEST(Plates, ThePlateThatIsOffIsNamed) {
  for (const std::size_t k : {0U, 1U, 3U}) {
    std::vector<Placing> plates = put_down();
    plates[k].height += 1;
    const std::string at = "--plates: the plate at " + std::to_string(static_cast<int>(kHeights.at(k))) + " mm lies ";
    expect_said(said_of(plates), at);
    plates = put_down();
    plates[k].bulge = -2;
    const std::string bent = said_of(plates);
    expect_said(bent, at);
    expect_said(bent, "mm lower than said; its height is wrong, or it is not flat");
  }
}

TEST(Plates, ThreeDoNotTellWhichOfThemIsOff) {
  std::vector<Placing> plates = put_down();
  plates.pop_back();
  EXPECT_EQ(said_of(plates), "none");
  plates[0].height += 2;
  expect_said(said_of(plates), "--plates: one of the plates at 0 or 20 or 40 mm lies higher or lower than said");
  plates[0].height -= 2;
  plates[1].x += 1;
  expect_said(said_of(plates), "--plates: one of the plates at 0 or 20 or 40 mm lies beside the others");
}

// The fit takes such heights as well as right ones: the focal length and the distance take up the factor.
TEST(Plates, HeightsAllWrongByOneFactorAreRefused) {
  const NarrowWorld narrow;
  const auto refusal = [&](double factor) {
    calibration::CalibrateSettings settings = narrow.settings();
    settings.free = {1, 0};
    for (calibration::PlatePlace& place : settings.plates->places) {
      place.height_mm *= factor;
    }
    for (double& height : settings.plates->heights_mm) {
      height *= factor;
    }
    return calibration::calibrate(narrow.observed(put_down()), settings).model.refusal;
  };
  EXPECT_EQ(refusal(1), "");
  for (const auto& [factor, times] : {std::pair(1.34, "1.34"), std::pair(0.93, "0.93")}) {
    const std::string reason = refusal(factor);
    EXPECT_NE(reason.find("the heights of --plates are likely all " + std::string(times) + " times the true ones"),
              std::string::npos)
        << reason;
  }
}

TEST(Plates, ScaleIsHeldAgainstTheDrawings) {
  const calibration::DrawnScale drawn{.distance_mm = 1000, .min_focal_px = 5000, .max_focal_px = 5200};
  EXPECT_EQ(calibration::fault_of_scale(drawn, 1029, 5355), "");
  EXPECT_EQ(calibration::fault_of_scale(drawn, 971, 4851), "");
  const auto names = [&](double distance, double focal, const std::string& reason) {
    return calibration::fault_of_scale(drawn, distance, focal).find(reason) != std::string::npos;
  };
  EXPECT_TRUE(names(1100, 5600, "are likely all 1.10 times the true ones"));
  EXPECT_TRUE(names(1040, 5200, "are likely all 1.04 times the true ones, or plane_z_mm of --rig is"));
  EXPECT_TRUE(names(1000, 4500, "--square or the focal length of --rig is likely wrong"));
  EXPECT_TRUE(names(1100, 4500, "--square or --rig is likely wrong"));
  EXPECT_TRUE(names(1000, std::nan(""), "--square or the focal length of --rig is likely wrong"));
}

}  // namespace
}  // namespace selfproj::test
