// Tests the belt of a light section in worlds of known truth: a chessboard that a belt carries past a camera that
// leans, and a laser's line on flat things of known height there.
#include "host/calibration/belt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"

namespace selfproj::test {
namespace {

constexpr double kPlane = 300;
const calibration::Chessboard kBeltBoard{7, 5, 8};

cv::Vec3d vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

// The truth: a lens with distortion, a belt that runs askew to it, a laser.
rig::Rig true_rig() {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.rows = 480;
  rig.camera.columns = 640;
  rig.calibration.emplace();
  rig.calibration->camera = {.fx_px = 1600, .fy_px = 1602, .cx_px = 325, .cy_px = 233, .k1 = -0.08};
  cv::Matx33d turn;
  cv::Rodrigues(cv::Vec3d(0.55, 0.1, -0.12), turn);
  const cv::Vec3d way = turn * cv::Vec3d(0, 1, 0);
  const cv::Vec3d normal = turn * cv::Vec3d(0, 0, 1);
  rig.belt_pose = rig::RigBeltPose{{way[0], way[1], way[2]}, {normal[0], normal[1], normal[2]}};
  rig.plane_z_mm = kPlane;
  const cv::Vec3d light = cv::normalize(cv::Vec3d(0.04, -0.8, 0.55));
  const cv::Vec3d aim(0, 0, kPlane / normal[2]);
  rig.light_plane = rig::RigLightPlane{{light[0], light[1], light[2]}, light.dot(aim)};
  rig.conveyor.encoder_mm_per_count = 0.0125;
  return rig;
}

rig::Lens lens_of(const rig::Rig& rig) {
  const rig::RigLens& l = rig.calibration->camera;
  return {l.fx_px, l.fy_px, l.cx_px, l.cy_px, {l.k1, l.k2, l.p1, l.p2, l.k3, 0, 0, 0}};
}

class BeltWorld {
 public:
  explicit BeltWorld(double noise_px) : noise_(noise_px) {}

  // The chessboard, `thickness` mm over the belt, turned by `turn_deg` and carried `along` mm.
  calibration::BoardImage board(double along, double thickness, double turn_deg, bool counted_back = false) {
    const cv::Vec3d way = vector_of(truth_.belt_pose->direction);
    const cv::Vec3d normal = vector_of(truth_.belt_pose->normal);
    const cv::Vec3d across = way.cross(normal);
    const double c = std::cos(turn_deg * CV_PI / 180);
    const double s = std::sin(turn_deg * CV_PI / 180);
    const cv::Vec3d right = c * across + s * way;
    const cv::Vec3d below = c * way - s * across;
    const cv::Vec3d middle = aim() - thickness * normal + along * way;
    calibration::BoardImage image;
    image.name = "belt" + std::to_string(static_cast<int>(along));
    image.rows = truth_.camera.rows;
    image.columns = truth_.camera.columns;
    for (int i = 0; i < kBeltBoard.corners(); ++i) {
      const cv::Point3d at = kBeltBoard.place(i);
      const cv::Vec3d point = middle + (at.x - 24) * right + (at.y - 16) * below;
      const cv::Vec2d pixel = lens_.pixel({point[0] / point[2], point[1] / point[2]});
      image.corners.emplace_back(pixel[0] + noise_ * normal_(random_), pixel[1] + noise_ * normal_(random_));
    }
    if (counted_back) {
      std::reverse(image.corners.begin(), image.corners.end());
    }
    image.used.assign(image.corners.size(), true);
    return image;
  }

  // The laser's line at a height, in every fourth column of a part of the image.
  calibration::LineAtHeight line(double height, int first = 20, int last = 620) {
    const cv::Vec3d normal = vector_of(truth_.belt_pose->normal);
    const cv::Vec3d light = vector_of(truth_.light_plane->normal);
    const cv::Vec3d along = cv::normalize(normal.cross(light));
    const cv::Matx33d planes(normal[0], normal[1], normal[2], light[0], light[1], light[2], along[0], along[1],
                             along[2]);
    const cv::Vec3d from = planes.inv() * cv::Vec3d(kPlane - height, truth_.light_plane->distance_mm, along.dot(aim()));
    calibration::LineAtHeight result{"line" + std::to_string(static_cast<int>(height)), height, {}};
    for (int c = first; c < last; c += 4) {
      double t = 0;
      const auto at = [&](double place) {
        const cv::Vec3d p = from + place * along;
        return lens_.pixel({p[0] / p[2], p[1] / p[2]});
      };
      for (int step = 0; step < 30; ++step) {
        t -= (at(t)[0] - c) * 1e-3 / (at(t + 1e-3)[0] - at(t)[0]);
      }
      result.centres.emplace_back(c, at(t)[1] + noise_ * normal_(random_));
    }
    return result;
  }

  [[nodiscard]] const rig::Rig& truth() const { return truth_; }

  // What a calibration of camera and laser leaves: the belt is the drawing's, and the laser's plane is a little off.
  [[nodiscard]] static rig::Rig believed(double light_deg) {
    rig::Rig rig = true_rig();
    rig.belt_pose.reset();
    rig.plane_z_mm = 1167;
    rig.conveyor.encoder_mm_per_count = 0.01;
    cv::Matx33d turn;
    cv::Rodrigues(cv::Vec3d(light_deg * CV_PI / 180, 0, 0), turn);
    const cv::Vec3d light = turn * vector_of(rig.light_plane->normal);
    const cv::Vec3d aim(0, 0, rig.light_plane->distance_mm / rig.light_plane->normal[2]);
    rig.light_plane = rig::RigLightPlane{{light[0], light[1], light[2]}, light.dot(aim) + 0.05};
    rig.sources = rig::RigSources{.camera = rig::ValueSource::measured, .light = rig::ValueSource::measured};
    return rig;
  }

 private:
  [[nodiscard]] cv::Vec3d aim() const { return {0, 0, kPlane / truth_.belt_pose->normal[2]}; }

  rig::Rig truth_ = true_rig();
  rig::Lens lens_ = lens_of(truth_);
  double noise_;
  std::mt19937_64 random_{5};
  std::normal_distribution<double> normal_;
};

double degrees_between(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::asin(cv::norm(vector_of(a).cross(vector_of(b)))) * 180 / CV_PI;
}

std::vector<calibration::BoardImage> carried(BeltWorld& world, double thickness, double turn_deg) {
  std::vector<calibration::BoardImage> boards;
  for (const double along : {-16.0, -8.0, 0.0, 8.0, 16.0}) {
    boards.push_back(world.board(along, thickness, turn_deg, along == 8));
  }
  return boards;
}

TEST(Belt, IsFoundByAChessboardThatItCarries) {
  for (const double turn : {0.0, 20.0, 100.0, 190.0}) {
    BeltWorld world(0.03);
    calibration::BeltSettings settings;
    settings.chessboard = kBeltBoard;
    settings.thickness_mm = 3;
    settings.counts = {100, 740, 1380, 2020, 2660};
    settings.moves_mm = {0, 8, 16, 24, 32};
    settings.seconds = {0, 0.1, 0.2, 0.3, 0.4};
    const calibration::BeltCalibration found =
        calibration::calibrate_belt(BeltWorld::believed(0), carried(world, 3, turn), {}, settings);
    const rig::Rig& truth = world.truth();
    EXPECT_LT(degrees_between(found.rig.belt_pose->normal, truth.belt_pose->normal), 0.1) << turn;
    EXPECT_LT(degrees_between(found.rig.belt_pose->direction, truth.belt_pose->direction), 0.1) << turn;
    EXPECT_GT(vector_of(found.rig.belt_pose->direction).dot(vector_of(truth.belt_pose->direction)), 0) << turn;
    EXPECT_LT(std::abs(found.rig.plane_z_mm - kPlane), 0.1) << turn;
    EXPECT_NEAR(found.rig.conveyor.encoder_mm_per_count, 0.0125, 0.0125 * 5e-4);
    EXPECT_NEAR(found.rig.conveyor.speed_mm_per_s, 80, 80 * 5e-4);
    EXPECT_NEAR(found.way, 1, 5e-4);
    EXPECT_LT(std::abs(found.rig.plane_z_mm - kPlane), 5 * found.distance_sd_mm);
    ASSERT_TRUE(found.rig.sources);
    EXPECT_EQ(found.rig.sources->belt, rig::ValueSource::measured);
    EXPECT_EQ(found.rig.sources->encoder, rig::ValueSource::measured);
    EXPECT_EQ(found.rig.sources->speed, rig::ValueSource::measured);
  }
}

// The lines on the belt and on a block that fills only a part of the view make heights exact, although the laser's
// plane is off.
TEST(Belt, LaserTiesZeroAndScale) {
  BeltWorld world(0.02);
  calibration::BeltSettings settings;
  settings.chessboard = kBeltBoard;
  settings.counts = {0, 640, 1280, 1920, 2560};
  calibration::LineAtHeight block = world.line(20, 200, 400);
  const calibration::LineAtHeight beside = world.line(0, 404, 620);
  block.centres.insert(block.centres.end(), beside.centres.begin(), beside.centres.end());
  const calibration::BeltCalibration found =
      calibration::calibrate_belt(BeltWorld::believed(0.15), carried(world, 0, 5), {world.line(0), block}, settings);
  ASSERT_EQ(found.heights.size(), 2U);
  EXPECT_NEAR(found.heights[0].mean_mm, 0, 0.002);
  EXPECT_NEAR(found.heights[1].mean_mm, 20, 0.002);
  EXPECT_EQ(found.heights[1].points, 50U);
  EXPECT_GT(std::abs(found.light_turn_deg), 0.05);
  EXPECT_EQ(found.rig.sources->speed, rig::ValueSource::drawing);
  // A height that took no part.
  calibration::BeltCalibration again =
      calibration::calibrate_belt(found.rig, carried(world, 0, 5), {world.line(0), world.line(10)}, settings);
  EXPECT_NEAR(again.light_turn_deg, 0, 0.01);
}

TEST(Belt, ContradictionsAreRefused) {
  BeltWorld world(0.02);
  calibration::BeltSettings settings;
  settings.chessboard = kBeltBoard;
  const auto refused = [&](const std::vector<calibration::BoardImage>& boards,
                           const std::vector<calibration::LineAtHeight>& lines = {}) -> std::string {
    try {
      calibration::calibrate_belt(BeltWorld::believed(0), boards, lines, settings);
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refused({world.board(0, 0, 0), world.board(2, 0, 0)}).find("the chessboard moved by "), std::string::npos);
  EXPECT_NE(refused({world.board(-16, 0, 0), world.board(0, 0, 6), world.board(16, 0, 0)}).find("it was touched"),
            std::string::npos);
  EXPECT_NE(refused(carried(world, 0, 0), {world.line(4)}).find("are the height, --thickness and --square right?"),
            std::string::npos);
  EXPECT_NE(refused(carried(world, 0, 0), {calibration::LineAtHeight{"dark.png", 0, {}}})
                .find("dark.png: nothing in it is brighter than --laser-threshold"),
            std::string::npos);
  calibration::LineAtHeight wrong = world.line(20);
  wrong.height_mm = 21;
  EXPECT_NE(refused(carried(world, 0, 0), {world.line(0), wrong}).find("the laser sees 0.95"), std::string::npos);
  settings.moves_mm = {0, 8.8, 17.6, 26.4, 35.2};
  EXPECT_NE(refused(carried(world, 0, 0)).find("a millimetre of the belt moves the chessboard by 0.909"),
            std::string::npos);
  settings.moves_mm.clear();
  // One value is wrong, or two images are exchanged.
  settings.counts = {0, 100, 200, 345, 400};
  EXPECT_NE(refused(carried(world, 0, 0)).find("--counts: by the other places, "), std::string::npos);
  settings.counts.clear();
  settings.seconds = {0, 2, 1, 3, 4};
  EXPECT_NE(refused(carried(world, 0, 0)).find("--seconds: by the other places, "), std::string::npos);
  settings.seconds.clear();
  settings.counts = {9, 8, 7, 6, 5};
  EXPECT_NE(refused(carried(world, 0, 0)).find("the encoder counts down"), std::string::npos);
}

}  // namespace
}  // namespace selfproj::test
