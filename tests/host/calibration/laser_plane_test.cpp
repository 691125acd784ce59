// Tests a camera alone and a laser's plane in worlds of known truth: plain views of a chessboard, and the line in which
// a plane of any orientation cuts it.
#include "host/calibration/laser_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/files/user_error.h"
#include "tests/support/chessboard_world.h"

namespace selfproj::test {
namespace {

struct Laser {
  cv::Vec3d normal;
  double distance;
};

calibration::CameraSettings camera_settings_of(const World& world) {
  calibration::CameraSettings settings;
  settings.chessboard = {world.chessboard_columns, world.chessboard_rows, world.square};
  return settings;
}

std::vector<calibration::BoardImage> seen(const World& world, const std::vector<ChessboardPose>& poses, double noise) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<calibration::BoardImage> images;
  for (const ChessboardPose& pose : poses) {
    calibration::BoardImage image;
    image.name = "image" + std::to_string(images.size());
    image.rows = world.camera_rows;
    image.columns = world.camera_columns;
    for (int i = 0; i < world.chessboard_columns * world.chessboard_rows; ++i) {
      const cv::Vec2d at = world.in_camera(pose.turn * world.on_chessboard(i) + pose.at);
      const double x = at[0] + noise * normal(random);
      image.corners.emplace_back(x, at[1] + noise * normal(random));
    }
    image.used.assign(image.corners.size(), true);
    images.push_back(image);
  }
  return images;
}

// The line of a laser on the plane of a chessboard: a Gaussian across the rows, 1.2 pixels wide.
images::Image line_on(const World& world, const ChessboardPose& pose, const Laser& laser) {
  const cv::Vec3d board(pose.turn(0, 2), pose.turn(1, 2), pose.turn(2, 2));
  images::Image image{world.camera_rows, world.camera_columns, {}};
  image.pixels.assign(static_cast<std::size_t>(image.rows * image.columns), 8);
  const cv::Vec3d along = cv::normalize(laser.normal.cross(board));
  const cv::Matx33d planes(laser.normal[0], laser.normal[1], laser.normal[2], board[0], board[1], board[2], along[0],
                           along[1], along[2]);
  const cv::Vec3d from = planes.inv() * cv::Vec3d(laser.distance, board.dot(pose.at), along.dot(pose.at));
  std::vector<double> rows(static_cast<std::size_t>(image.columns), -1);
  for (int step = -4000; step <= 4000; ++step) {
    const cv::Vec2d at = world.in_camera(from + 0.1 * step * along);
    const cv::Vec2d next = world.in_camera(from + 0.1 * (step + 1) * along);
    const double left = std::min(at[0], next[0]);
    const double right = std::max(at[0], next[0]);
    for (int c = std::max(0, static_cast<int>(std::ceil(left))); c <= right && c < image.columns; ++c) {
      rows[static_cast<std::size_t>(c)] = at[1] + (c - at[0]) / (next[0] - at[0]) * (next[1] - at[1]);
    }
  }
  for (int c = 0; c < image.columns; ++c) {
    for (int r = 0; r < image.rows; ++r) {
      const double off = (r - rows[static_cast<std::size_t>(c)]) / 1.2;
      image.pixels[static_cast<std::size_t>(r * image.columns + c)] =
          static_cast<std::uint8_t>(std::lround(8 + 200 * std::exp(-0.5 * off * off)));
    }
  }
  return image;
}

TEST(LaserPlane, CameraAndPlaneOfAnyOrientation) {
  World world;
  world.camera.k1 = -0.12;
  const std::vector<ChessboardPose> poses = world.poses();
  const calibration::CameraReport camera =
      calibration::calibrate_camera(seen(world, poses, 0.02), camera_settings_of(world));
  EXPECT_EQ(camera.model.refusal, "");
  const calibration::BundleResult& found = camera.model.result;
  const std::array<double, 5> truth{world.camera.fx, world.camera.fy, world.camera.cx, world.camera.cy,
                                    world.camera.k1};
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT(std::abs(found.bundle.camera.at(i) - truth.at(i)), 4 * found.deviation.camera.at(i)) << i;
  }
  EXPECT_LT(found.deviation.camera[0], 1);
  for (const double roll : {0.0, 12.0, -25.0}) {
    SCOPED_TRACE(roll);
    const cv::Vec3d normal = test::turn(35, 0, 0) * test::turn(0, 0, roll) * cv::Vec3d(0, 1, 0);
    const Laser laser{normal, normal.dot(cv::Vec3d(0, 10, 560))};
    std::vector<images::Image> lines;
    for (const ChessboardPose& pose : poses) {
      lines.push_back(line_on(world, pose, laser));
    }
    const calibration::LaserPlane plane = calibration::laser_plane(camera, lines);
    const std::array<double, 3>& n = plane.plane.normal;
    const double sign = laser.distance < 0 ? -1 : 1;
    const double off = 180 / CV_PI * cv::norm(sign * normal - cv::Vec3d(n[0], n[1], n[2]));
    EXPECT_LT(off, std::max(0.05, 4 * plane.turn_sd_deg));
    EXPECT_LT(plane.turn_sd_deg, 0.2);
    EXPECT_NEAR(plane.plane.distance_mm, sign * laser.distance, 1);
    EXPECT_LT(plane.rms_mm, 0.5);
    EXPECT_GE(plane.images, 6U);
  }
}

// What a camera of colours sees of a board in room light with a red laser's line on it: the laser's light alone (red
// less the mean of the others), and the mean of the others.
struct RoomPicture {
  images::Image others, light;
};
RoomPicture room_picture(const World& world, const ChessboardPose& pose, const Laser& laser, std::mt19937_64& random) {
  constexpr int kFine = 2;
  constexpr double kWidth = 0.7;  // mm: standard deviation of the line's light across
  constexpr double kVeil = 25;    // mm
  std::normal_distribution<double> noise(0, 1);
  const cv::Vec3d board(pose.turn(0, 2), pose.turn(1, 2), pose.turn(2, 2));
  RoomPicture picture{{world.camera_rows, world.camera_columns, {}}, {world.camera_rows, world.camera_columns, {}}};
  const auto to_grey = [&](double value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value + noise(random)), 0L, 255L));
  };
  for (int r = 0; r < world.camera_rows; ++r) {
    for (int c = 0; c < world.camera_columns; ++c) {
      double room = 0;
      double lit = 0;
      for (int k = 0; k < kFine * kFine; ++k) {
        const double column = c + 1.6 * ((k % kFine + 0.5) / kFine - 0.5);
        const double row = r + 1.6 * ((k / kFine + 0.5) / kFine - 0.5);  // NOLINT: whole
        const cv::Vec3d ray((column - world.camera.cx) / world.camera.fx, (row - world.camera.cy) / world.camera.fy, 1);
        const cv::Vec3d p = ray * (board.dot(pose.at) / board.dot(ray));
        const cv::Vec3d b = pose.turn.t() * (p - pose.at) * (1 / world.square);
        const bool paper =
            b[0] > -1.7 && b[1] > -1.7 && b[0] < world.chessboard_columns + 0.7 && b[1] < world.chessboard_rows + 0.7;
        const bool squares = b[0] > -1 && b[1] > -1 && b[0] < world.chessboard_columns && b[1] < world.chessboard_rows;
        const bool black =
            squares && (static_cast<int>(std::floor(b[0])) + static_cast<int>(std::floor(b[1]))) % 2 == 0;
        const double albedo = !paper ? 0.3 : black ? 0.1 : 1;
        const double away = std::abs(laser.normal.dot(p) - laser.distance);
        room += 130 * albedo / (kFine * kFine);
        lit += (600 * albedo * std::exp(-away * away / (2 * kWidth * kWidth)) + 50 * std::exp(-away / kVeil)) /
               (kFine * kFine);
      }
      const double others = to_grey(room + 0.15 * lit);
      const double red = to_grey(room + lit);
      picture.others.pixels.push_back(static_cast<std::uint8_t>(others));
      picture.light.pixels.push_back(static_cast<std::uint8_t>(std::max(0.0, red - others)));
    }
  }
  return picture;
}

// From pictures that show board and line at once: all 14 boards are found, and the plane is right over the whole range
// in which the boards were.
TEST(LaserPlane, OfBoardsInRoomLight) {
  World world;
  world.camera = {900, 902, 318, 243};
  world.camera_columns = 640;
  world.camera_rows = 480;
  world.chessboard_columns = 9;
  world.chessboard_rows = 6;
  world.square = 25;
  const cv::Vec3d normal = test::turn(40, 0, 0) * test::turn(0, 0, 4) * cv::Vec3d(0, 1, 0);
  const Laser laser{normal, normal.dot(cv::Vec3d(0, 5, 480))};
  std::vector<ChessboardPose> poses;
  for (int i = 0; i < 14; ++i) {  // as a person holds it: nearer and further away, leaning in all directions
    const double angle = 2.4 * i;
    const double lean = i == 0 ? 0 : 18 + 2 * (i % 5);
    const double z = 475 + 7 * (i % 8 - 3.5);
    // The board follows the light, so that the line crosses it.
    const double y = (laser.distance - normal[2] * z) / normal[1] + 6 * std::sin(1.7 * i);
    poses.push_back(world.pose(12 * std::cos(angle), y, z,
                               test::turn(lean * std::cos(angle), lean * std::sin(angle), 12 * std::sin(2.0 * i))));
  }
  std::mt19937_64 random(5);
  std::vector<calibration::BoardImage> boards;
  std::vector<images::Image> lines;
  calibration::CameraSettings settings = camera_settings_of(world);
  settings.bent = false;
  for (const ChessboardPose& pose : poses) {
    RoomPicture picture = room_picture(world, pose, laser, random);
    boards.push_back(calibration::observe_board("pose " + std::to_string(boards.size() + 1), picture.others,
                                                settings.chessboard, &picture.light));
    EXPECT_EQ(boards.back().reason, "") << boards.back().name;
    EXPECT_GE(boards.back().used_corners(), 24) << boards.back().name;
    lines.push_back(std::move(picture.light));
  }
  const calibration::CameraReport camera = calibration::calibrate_camera(boards, settings);
  ASSERT_EQ(camera.model.refusal, "");
  EXPECT_NEAR(camera.model.result.bundle.camera[0], world.camera.fx, 3);
  const calibration::LaserPlane plane = calibration::laser_plane(camera, lines);
  EXPECT_EQ(plane.images, poses.size());
  // Points of the true plane, as far as the boards reached.
  double squares = 0;
  int points = 0;
  for (double x = -90; x <= 90; x += 15) {
    for (double z = 450; z <= 500; z += 5) {
      const double y = (laser.distance - normal[2] * z - normal[0] * x) / normal[1];
      const auto& n = plane.plane.normal;
      squares += std::pow(n[0] * x + n[1] * y + n[2] * z - plane.plane.distance_mm, 2);
      ++points;
    }
  }
  EXPECT_LT(std::sqrt(squares / points), 0.15);
  RecordProperty("plane_rms_um", static_cast<int>(1000 * std::sqrt(squares / points)));
}

TEST(LaserPlane, WhatDoesNotTellIsRefused) {
  const World world;
  const std::vector<ChessboardPose> poses = world.poses();
  const calibration::CameraReport camera =
      calibration::calibrate_camera(seen(world, poses, 0.02), camera_settings_of(world));
  std::vector<images::Image> dark(poses.size(), images::Image{world.camera_rows, world.camera_columns, {}});
  for (images::Image& image : dark) {
    image.pixels.assign(static_cast<std::size_t>(image.rows * image.columns), 8);
  }
  EXPECT_THROW(calibration::laser_plane(camera, dark), UserError);
  // Lines of other poses than the boards
  const cv::Vec3d normal = test::turn(35, 0, 0) * cv::Vec3d(0, 1, 0);
  std::vector<images::Image> lines;
  for (const ChessboardPose& pose : poses) {
    lines.push_back(line_on(world, pose, {normal, normal.dot(cv::Vec3d(0, 10, 560))}));
  }
  std::rotate(lines.begin(), lines.begin() + 1, lines.end());
  try {
    calibration::laser_plane(camera, lines);
    ADD_FAILURE();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("are boards and lines in the same order"), std::string::npos);
  }
  // Parallel poses do not determine the focal length.
  const calibration::CameraReport parallel = calibration::calibrate_camera(
      seen(world,
           {world.pose(0, 0, 560, test::turn(0.2, 0, 0)), world.pose(20, 5, 580, test::turn(0, 0.2, 4)),
            world.pose(-20, 5, 540, test::turn(0, 0, -4))},
           0.1),
      camera_settings_of(world));
  EXPECT_NE(parallel.model.refusal, "");
  EXPECT_THROW(calibration::calibrate_camera(seen(world, {poses[0]}, 0.02), camera_settings_of(world)), UserError);
}

}  // namespace
}  // namespace selfproj::test
