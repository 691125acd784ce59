// Tests calibration against worlds of known truth: corners from codes, the least squares and their standard deviations,
// rejection and warnings.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/calibrate.h"
#include "host/calibration/capture.h"
#include "host/calibration/laser_plane.h"
#include "host/calibration/model_choice.h"
#include "tests/support/chessboard_world.h"
#include "tests/support/error_of.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

calibration::CalibrateSettings settings_of(const World& world) {
  calibration::CalibrateSettings settings;
  settings.chessboard = {world.chessboard_columns, world.chessboard_rows, world.square};
  settings.projector_columns = world.projector_columns;
  settings.projector_rows = world.projector_rows;
  return settings;
}

// What would be observed, with normal noise of these standard deviations.
std::vector<calibration::PoseReport> observed(const World& world, const std::vector<ChessboardPose>& poses,
                                              double camera_noise, double projector_noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<calibration::PoseReport> reports;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    calibration::PoseReport report;
    report.name = "pose" + std::to_string(p);
    report.rows = world.camera_rows;
    report.columns = world.camera_columns;
    for (int i = 0; i < world.chessboard_columns * world.chessboard_rows; ++i) {
      const cv::Vec3d at = poses[p].turn * world.on_chessboard(i) + poses[p].at;
      const cv::Vec2d camera = world.in_camera(at) + camera_noise * cv::Vec2d(normal(random), normal(random));
      const cv::Vec2d projector = world.in_projector(at) + projector_noise * cv::Vec2d(normal(random), normal(random));
      calibration::Corner corner;
      corner.camera = {camera[0], camera[1]};
      corner.projector = {projector[0], projector[1]};
      corner.used = true;
      report.corners.push_back(corner);
    }
    reports.push_back(report);
  }
  return reports;
}

World distorted() {
  World world;
  world.camera = {260, 261, 118, 102, -0.2, 0.1, 0.002, -0.001, -0.05};
  world.projector = {150, 151, 49, 41, 0.1, -0.2, -0.001, 0.0015, 0.1};
  return world;
}

std::array<double, 9> parameters(const rig::Lens& l) {
  return {l.fx, l.fy, l.cx, l.cy, l.k[0], l.k[1], l.k[2], l.k[3], l.k[4]};
}
std::array<double, 9> parameters(const WorldLens& l) { return {l.fx, l.fy, l.cx, l.cy, l.k1, l.k2, l.p1, l.p2, l.k3}; }

TEST(Calibrate, ExactCornersGiveTheTruth) {
  for (const bool mirrored : {false, true}) {
    SCOPED_TRACE(mirrored);
    World world = distorted();
    world.mirrored = mirrored;
    calibration::CalibrateSettings settings = settings_of(world);
    settings.free = {5, 5};
    const calibration::CalibrationReport report =
        calibration::calibrate(observed(world, world.poses(), 0, 0, 1), settings);
    EXPECT_LT(report.bundle.rms, 1e-6);
    EXPECT_EQ(report.mirrored, mirrored);
    const auto camera = parameters(world.camera);
    auto projector = parameters(world.projector);
    if (mirrored) {  // the rows counted from below: fy changes its sign
      projector[1] *= -1;
      projector[3] = world.projector_rows - 1 - projector[3];
    }
    for (std::size_t i = 0; i < camera.size(); ++i) {
      constexpr double kNear = 1e-4;
      EXPECT_NEAR(parameters(report.calibration.camera)[i], camera[i], kNear) << i;
      EXPECT_NEAR(parameters(report.calibration.projector)[i], projector[i], kNear) << i;
    }
    EXPECT_LT(cv::norm(report.calibration.rotation - world.rotation), 1e-6);
    EXPECT_LT(cv::norm(report.calibration.translation - world.translation), 1e-3);
    for (const calibration::PoseReport& pose : report.poses) {
      EXPECT_EQ(pose.used(), settings.chessboard.corners());
    }
    // The lens of the result maps points as the world does, mirrored or not.
    const cv::Vec3d point(30, -20, 600);
    const cv::Vec3d there = report.calibration.rotation * point + report.calibration.translation;
    const cv::Vec2d seen = report.calibration.projector.pixel({there[0] / there[2], there[1] / there[2]});
    EXPECT_LT(cv::norm(seen - world.in_projector(point)), 1e-4);
  }
}

// Errors divided by their estimated standard deviations have mean square 1, for each parameter.
TEST(Calibrate, StandardDeviationsAreThoseOfTheErrors) {
  const World world = distorted();
  calibration::CalibrateSettings settings = settings_of(world);
  settings.free = {5, 5};
  settings.reject = 0;
  constexpr int kRuns = 20;
  std::array<double, 25> squares{};
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const calibration::CalibrationReport report =
        calibration::calibrate(observed(world, world.poses(), 0.05, 0.15, seed), settings);
    std::size_t at = 0;
    const auto add = [&](double value, double truth, double deviation) {
      squares[at++] += std::pow((value - truth) / deviation, 2) / kRuns;
    };
    for (std::size_t i = 0; i < calibration::kLensParameters; ++i) {
      add(report.bundle.bundle.camera[i], parameters(world.camera)[i], report.bundle.deviation.camera[i]);
      add(report.bundle.bundle.projector[i], parameters(world.projector)[i], report.bundle.deviation.projector[i]);
    }
    for (int i = 0; i < 3; ++i) {
      add(report.bundle.bundle.stereo.translation[i], world.translation[i],
          report.bundle.deviation.stereo.translation[i]);
    }
    cv::Vec3d rotation;
    cv::Rodrigues(world.rotation, rotation);
    for (int i = 0; i < 3; ++i) {
      add(report.bundle.bundle.stereo.rotation[i], rotation[i], report.bundle.deviation.stereo.rotation[i]);
    }
    add(cv::norm(report.calibration.translation), cv::norm(world.translation), report.bundle.baseline_deviation);
    EXPECT_NEAR(report.bundle.camera_rms, 0.05 * std::sqrt(2.0), 0.01);
    EXPECT_NEAR(report.bundle.projector_rms, 0.15 * std::sqrt(2.0), 0.03);
  }
  double mean = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {  // chi square of 20 degrees of freedom over 20: 1 ± 0.32
    EXPECT_GT(squares[i], 0.3) << i;
    EXPECT_LT(squares[i], 2.2) << i;
    mean += squares[i] / static_cast<double>(squares.size());
  }
  EXPECT_NEAR(mean, 1, 0.4);  // many parameters go together
}

TEST(Calibrate, RejectsAndSaysSo) {
  const World world;
  std::vector<calibration::PoseReport> poses = observed(world, world.poses(), 0.05, 0.1, 3);
  poses[2].corners[11].camera.x += 1.5;
  poses[5].corners[0].projector.y -= 3;
  poses[1].corners[4].used = false;
  poses[1].corners[4].reason = "hidden";
  const calibration::CalibrationReport report = calibration::calibrate(poses, settings_of(world));
  EXPECT_FALSE(report.poses[2].corners[11].used);
  EXPECT_NE(report.poses[2].corners[11].reason.find("in the camera; the limit is"), std::string::npos);
  EXPECT_FALSE(report.poses[5].corners[0].used);
  EXPECT_NE(report.poses[5].corners[0].reason.find("in the projector; the limit is"), std::string::npos);
  EXPECT_EQ(report.poses[1].corners[4].reason, "hidden");
  int used = 0;
  for (const calibration::PoseReport& pose : report.poses) {
    used += pose.used();
  }
  EXPECT_GE(used, 8 * 35 - 5);
  EXPECT_NEAR(report.calibration.camera.fx, world.camera.fx, 2);
  // It keeps them if it is set to.
  calibration::CalibrateSettings keep = settings_of(world);
  keep.reject = 0;
  EXPECT_TRUE(calibration::calibrate(poses, keep).poses[2].corners[11].used);
}

TEST(Calibrate, LeavesOutPosesAndSaysSo) {
  const World world;
  std::vector<calibration::PoseReport> poses = observed(world, world.poses(), 0.05, 0.1, 4);
  for (std::size_t i = 0; i + 5 < poses[3].corners.size(); ++i) {
    poses[3].corners[i].used = false;
  }
  poses[4].corners.clear();
  poses[4].reason = "no board";
  const calibration::CalibrationReport report = calibration::calibrate(poses, settings_of(world));
  EXPECT_EQ(report.poses[3].reason, "only 5 of 35 corners can be used; 12 are needed");
  EXPECT_EQ(report.poses[4].reason, "no board");
  EXPECT_EQ(report.bundle.bundle.chessboard.size(), 6U);
}

std::string error_of(const std::vector<calibration::PoseReport>& poses,
                     const calibration::CalibrateSettings& settings) {
  return test::error_of([&] { calibration::calibrate(poses, settings); });
}

TEST(Calibrate, WhatCannotBeDone) {
  const World world;
  const calibration::CalibrateSettings settings = settings_of(world);
  std::vector<calibration::PoseReport> poses = observed(world, {world.poses()[1]}, 0.05, 0.1, 1);
  EXPECT_EQ(
      error_of(poses, settings),
      "calibrate: 1 of 1 poses can be used; at least 2 are needed, and 3 or more in different directions advised");
  poses = observed(world, {world.poses()[1], world.poses()[2]}, 0.05, 0.1, 1);
  poses[1].reason = "no board";
  EXPECT_EQ(
      error_of(poses, settings),
      "calibrate: 1 of 2 poses can be used; at least 2 are needed, and 3 or more in different directions advised; "
      "pose1: no board");
  poses[1].reason.clear();
  poses[1].rows = 100;
  EXPECT_EQ(error_of(poses, settings), "pose1: has images of 240 x 100, but pose0 of 240 x 200");
}

bool warns(const calibration::CalibrationReport& report, const std::string& of) {
  return std::any_of(report.warnings.begin(), report.warnings.end(),
                     [&](const std::string& warning) { return warning.find(of) != std::string::npos; });
}

TEST(Calibrate, WarnsOfWhatTheDataCannotTell) {
  World world;
  const calibration::CalibrateSettings settings = settings_of(world);
  const calibration::CalibrationReport good =
      calibration::calibrate(observed(world, world.poses(), 0.02, 0.02, 1), settings);
  EXPECT_FALSE(warns(good, "parallel"));
  EXPECT_FALSE(warns(good, "poses:"));
  EXPECT_FALSE(warns(good, "camera fx"));
  EXPECT_EQ(good.model.refusal, "");
  const calibration::CalibrationReport two =
      calibration::calibrate(observed(world, {world.poses()[1], world.poses()[4]}, 0.05, 0.1, 1), settings);
  EXPECT_TRUE(warns(two, "only 2 poses"));
  std::vector<ChessboardPose> parallel;
  for (const double x : {-40.0, 0.0, 40.0}) {
    parallel.push_back(world.pose(x, 10 + 0.1 * x, 560 + x, test::turn(0.5, 0.5, 0.3 * x)));
  }
  const calibration::CalibrationReport flat = calibration::calibrate(observed(world, parallel, 0.05, 0.1, 1), settings);
  EXPECT_TRUE(warns(flat, "all poses are parallel within"));
  EXPECT_NE(flat.model.refusal, "");
}

// A second solution, as the data of weak poses have one: here a result is moved, and its cost says that it fits alike.
TEST(Calibrate, StartsThatDisagreeAreRefused) {
  const World world;
  const calibration::CalibrateSettings settings = settings_of(world);
  const std::vector<calibration::PoseReport> poses = observed(world, world.poses(), 0.05, 0.1, 5);
  std::vector<calibration::View> views;
  for (const calibration::PoseReport& pose : poses) {
    views.push_back(calibration::view_of(pose, settings, false));
  }
  const calibration::ModelSettings model{{world.camera_columns, world.camera_rows},
                                         {world.projector_columns, world.projector_rows},
                                         settings.free,
                                         nullptr};
  const calibration::ModelChoice chosen = calibration::choose_model(views, model);
  calibration::ModelChoice same = chosen;
  calibration::check_starts(views, model, same);
  EXPECT_EQ(same.refusal, "");
  EXPECT_GE(same.agreeing, 6);

  const auto moved = [&](double deviations, double chi_square) {
    calibration::ModelChoice choice = chosen;
    choice.result.bundle.camera[0] += deviations * chosen.result.deviation.camera[0];
    choice.result.cost += 0.5 * chi_square;
    calibration::check_starts(views, model, choice);
    return choice;
  };
  EXPECT_EQ(moved(0.1, 0).refusal, "");
  const calibration::ModelChoice alike = moved(2, 0);
  EXPECT_EQ(alike.refusal.rfind("different starts end in different solutions that fit alike: camera fx ", 0), 0U)
      << alike.refusal;
  EXPECT_EQ(alike.agreeing, 0);
  EXPECT_NE(moved(2, -10).refusal, "");
  const calibration::ModelChoice worse = moved(2, -100);  // the starts' solutions are out of the question
  EXPECT_EQ(worse.refusal, "");
  EXPECT_GE(worse.worse, 6);
  const calibration::ModelChoice better = moved(2, 10);  // one of them takes the result's place
  EXPECT_EQ(better.refusal, "");
  EXPECT_NEAR(better.result.bundle.camera[0], chosen.result.bundle.camera[0], 0.01);
}

// What a capture of a projector of this size, whose pixels are 8 x 8 of the camera, says where another size is claimed.
std::string contradiction_of(const cv::Size& projector, const cv::Size& claimed) {
  constexpr int kEach = 8;
  const structured_light::GraySequence shown(projector.width, projector.height);
  images::ImageSequence captured(
      std::vector<std::string>(static_cast<std::size_t>(shown.count()), "image"), [&](std::size_t i) {
        const std::vector<std::uint8_t> pattern = shown.image(static_cast<int>(i));
        images::Image image{kEach * projector.height, kEach * projector.width, {}};
        for (int r = 0; r < image.rows; ++r) {
          for (int c = 0; c < image.columns; ++c) {
            const int at = r / kEach * projector.width + c / kEach;
            image.pixels.push_back(static_cast<std::uint8_t>(pattern[static_cast<std::size_t>(at)] / 2 + 20));
          }
        }
        return image;
      });
  return calibration::decode_capture("pose", captured, structured_light::GraySequence(claimed.width, claimed.height),
                                     {})
      .contradiction;
}

TEST(DecodeCapture, CodesBeyondTheProjectorSayThatItsSizeIsWrong) {
  EXPECT_EQ(contradiction_of({32, 24}, {32, 24}), "");
  EXPECT_EQ(contradiction_of({30, 24}, {32, 24}), "") << "a larger one may be lit in part";
  EXPECT_EQ(contradiction_of({32, 24}, {20, 24}),
            "37.5 % of the pixels see columns from 20 on, up to 31, but the projector is said to have 20");
  EXPECT_EQ(contradiction_of({32, 24}, {32, 18}),
            "25.0 % of the pixels see rows from 18 on, up to 23, but the projector is said to have 18");
  EXPECT_NE(contradiction_of({32, 24}, {24, 32}).find("see columns from 24 on, up to 31"), std::string::npos)
      << "width and height exchanged";
}

TEST(Calibrate, WithoutCapturesItSaysSo) {
  EXPECT_EQ(test::error_of([] { calibration::calibrate({}, {}); }), "calibrate: there are no captures");
  EXPECT_EQ(test::error_of([] { calibration::calibrate_camera({}, {}); }), "calibrate camera: there are no images");
}

// A capture whose codes are those of a homography, rounded.
struct Window {
  calibration::Capture capture;
  cv::Point2d camera{40.3, 37.8};
  cv::Point2d projector;
};
Window window_of(Random& random, double wrong_share) {
  const auto real = [&](double low, double high) {
    return low + (high - low) * random.between(0, 1 << 20) / (1 << 20);
  };
  Window window;
  calibration::Capture& capture = window.capture;
  capture.rows = capture.columns = 80;
  const cv::Matx33d h(real(0.8, 2.5), real(-0.5, 0.5), real(200, 400), real(-0.5, 0.5), real(0.8, 2.5), real(200, 400),
                      real(-5e-4, 5e-4), real(-5e-4, 5e-4), 1);
  const auto mapped = [&](double x, double y) {
    const cv::Vec3d p = h * cv::Vec3d(x, y, 1);
    return cv::Point2d(p[0] / p[2], p[1] / p[2]);
  };
  for (int r = 0; r < capture.rows; ++r) {
    for (int c = 0; c < capture.columns; ++c) {
      cv::Point2d code = mapped(c, r);
      const bool none = (c > 40) != (r > 38) && random.chance(80);  // black squares
      if (random.chance(static_cast<int>(100 * wrong_share))) {
        code += cv::Point2d(random.between(-64, 64), random.between(-64, 64));
      }
      capture.projector_column.push_back(none ? calibration::Capture::kNone
                                              : static_cast<std::int16_t>(std::lround(code.x)));
      capture.projector_row.push_back(none ? calibration::Capture::kNone
                                           : static_cast<std::int16_t>(std::lround(code.y)));
    }
  }
  window.projector = mapped(window.camera.x, window.camera.y);
  return window;
}

TEST(CornerCode, BothWaysFindTheCorner) {
  double squares = 0;
  double predicted = 0;
  int count = 0;
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const Window window = window_of(random, random.chance(50) ? 0.1 : 0);
    for (const calibration::CornerMethod method :
         {calibration::CornerMethod::homography, calibration::CornerMethod::direct}) {
      const calibration::CornerCode found =
          calibration::corner_code(window.capture, window.camera, 24, {method, 0, 0.3});
      ASSERT_TRUE(found.valid);
      const cv::Point2d off = found.projector - window.projector;
      EXPECT_LT(cv::norm(off), 0.12);
      EXPECT_LT(found.sd_px, 0.1);
      squares += off.dot(off) / 2;
      predicted += found.sd_px * found.sd_px;
      ++count;
    }
  }
  if (count > 40) {
    EXPECT_LT(std::sqrt(squares / count), 1.3 * std::sqrt(predicted / count));
  }
}

TEST(CornerCode, TooLittleIsNothing) {
  Random random(1);
  for (const calibration::CornerMethod method :
       {calibration::CornerMethod::homography, calibration::CornerMethod::direct}) {
    Window window = window_of(random, 0);
    EXPECT_FALSE(
        calibration::corner_code(window.capture, window.camera, 24, {method, 0, 1e-4}).valid);  // not that certain
    for (std::size_t i = 0; i < window.capture.projector_row.size(); ++i) {
      if (i % 80 > 38) {  // nothing on the right
        window.capture.projector_column[i] = window.capture.projector_row[i] = calibration::Capture::kNone;
      }
    }
    EXPECT_FALSE(calibration::corner_code(window.capture, window.camera, 24, {method, 0, 0.3}).valid);
    std::fill(window.capture.projector_column.begin(), window.capture.projector_column.end(),
              calibration::Capture::kNone);
    EXPECT_EQ(calibration::corner_code(window.capture, window.camera, 24, {method, 0, 0.3}).pixels, 0);
  }
}

}  // namespace
}  // namespace selfproj::test
