// Calibrates from captures made by others (../shared/data, not part of the project): a chessboard in three poses.
// Reports that it is skipped if they, or OpenCV's structured_light module, are missing.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/calibrate.h"
#include "host/calibration/capture.h"
#include "host/calibration/chessboard.h"
#include "host/files/results_file.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "selfproj/structured_light/gray_sequence.h"

#ifdef SELFPROJ_HAS_OPENCV_STRUCTURED_LIGHT
#include <opencv2/structured_light/graycodepattern.hpp>
#endif

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

constexpr int kPoses = 3;
const structured_light::GraySequence kSequence(1024, 768);

std::string folder_of(int pose) {
  const fs::path data = fs::path(SELFPROJ_SOURCE_DIR) / "../shared/data";
  return (data / ("gray-kamino-pose" + std::to_string(pose)) / ("capture_" + std::to_string(pose))).string();
}

calibration::Capture capture_of(int pose, const calibration::DecodeSettings& settings) {
  const std::string folder = folder_of(pose);
  images::ImageSequence images(images::files_of_folder(folder), std::nullopt);
  return calibration::decode_capture(folder, images, kSequence, settings);
}

// The chessboard in its three poses, found with both kinds of corners.
class RealChessboard {
 public:
  RealChessboard() {
    settings.chessboard = {9, 7, 75};
    settings.projector_columns = kSequence.columns();
    settings.projector_rows = kSequence.rows();
    for (int pose = 0; pose < kPoses; ++pose) {
      const calibration::Capture capture = capture_of(pose, {});
      settings.corners.method = calibration::CornerMethod::direct;
      direct.push_back(calibration::observe_pose(folder_of(pose), capture, settings));
      settings.corners.method = calibration::CornerMethod::homography;
      homography.push_back(calibration::observe_pose(folder_of(pose), capture, settings));
    }
  }

  calibration::CalibrateSettings settings;
  std::vector<calibration::PoseReport> homography, direct;
};

nlohmann::ordered_json three_poses(const RealChessboard& real) {
  calibration::CalibrateSettings settings = real.settings;
  nlohmann::ordered_json results;
  for (const calibration::CornerMethod method :
       {calibration::CornerMethod::homography, calibration::CornerMethod::direct}) {
    settings.corners.method = method;
    const std::vector<calibration::PoseReport>& poses =
        method == calibration::CornerMethod::homography ? real.homography : real.direct;
    for (const calibration::PoseReport& pose : poses) {
      EXPECT_EQ(pose.used(), settings.chessboard.corners());
    }
    for (const double reject : {0.0, 4.5}) {
      settings.reject = reject;
      const calibration::CalibrationReport report = calibration::calibrate(poses, settings);
      const calibration::BundleResult& found = report.bundle;
      int used = 0;
      for (const calibration::PoseReport& pose : report.poses) {
        used += pose.used();
      }
      constexpr double kFocal = 3452;  // that of five poses
      results[method == calibration::CornerMethod::homography ? "homography" : "direct"]
             [reject > 0 ? "rejecting" : "all_corners"] = {
                 {"corners", used},
                 {"camera_focal_px", report.calibration.camera.fx},
                 {"camera_focal_deviation_px", found.deviation.camera[0]},
                 {"off_five_poses", std::abs(report.calibration.camera.fx / kFocal - 1)},
                 {"projector_focal_px", report.calibration.projector.fx},
                 {"projector_focal_deviation_px", found.deviation.projector[0]},
                 {"baseline", cv::norm(report.calibration.translation)},
                 {"baseline_deviation", found.baseline_deviation},
                 {"camera_rms_px", found.camera_rms},
                 {"projector_rms_px", found.projector_rms},
                 {"stereo_rms_px", found.rms}};
      EXPECT_NEAR(report.calibration.camera.fx, kFocal, 0.015 * kFocal);
      EXPECT_NEAR(report.calibration.camera.fy, kFocal, 0.015 * kFocal);
      EXPECT_LE(found.rms, 0.7);
      EXPECT_LE(found.camera_rms, 0.7);
      EXPECT_LE(found.projector_rms, 0.7);
      EXPECT_FALSE(report.mirrored);
      for (std::size_t i = 0; i < calibration::kLensParameters; ++i) {
        const bool estimated = i < 4 + static_cast<std::size_t>(report.model.free.camera);
        EXPECT_EQ(found.deviation.camera[i] > 0 && std::isfinite(found.deviation.camera[i]), estimated) << i;
        const bool lit = i < 4 + static_cast<std::size_t>(report.model.free.projector);
        EXPECT_EQ(found.deviation.projector[i] > 0 && std::isfinite(found.deviation.projector[i]), lit) << i;
      }
      EXPECT_GE(used, reject > 0 ? 150 : 3 * 63);
      // The corners lie only in the middle of both images.
      const auto covers = [](const std::string& warning) {
        return warning.find("corners cover only") != std::string::npos;
      };
      EXPECT_EQ(std::count_if(report.warnings.begin(), report.warnings.end(), covers), 2);
    }
  }
  return results;
}

// The greatest difference between two calibrations in a focal length, a centre, the projector's place or its turn, in
// standard deviations of the difference.
double farthest(const calibration::CalibrationReport& a, const calibration::CalibrationReport& b) {
  double most = 0;
  const auto compare = [&](double x, double y, double dx, double dy) {
    most = std::max(most, std::abs(x - y) / std::hypot(dx, dy));
  };
  const calibration::BundleResult& p = a.bundle;
  const calibration::BundleResult& q = b.bundle;
  for (std::size_t i = 0; i < calibration::kPinholeParameters; ++i) {
    compare(p.bundle.camera[i], q.bundle.camera[i], p.deviation.camera[i], q.deviation.camera[i]);
    compare(p.bundle.projector[i], q.bundle.projector[i], p.deviation.projector[i], q.deviation.projector[i]);
  }
  for (int i = 0; i < 3; ++i) {
    compare(p.bundle.stereo.translation[i], q.bundle.stereo.translation[i], p.deviation.stereo.translation[i],
            q.deviation.stereo.translation[i]);
    compare(p.bundle.stereo.rotation[i], q.bundle.stereo.rotation[i], p.deviation.stereo.rotation[i],
            q.deviation.stereo.rotation[i]);
  }
  compare(cv::norm(p.bundle.stereo.translation), cv::norm(q.bundle.stereo.translation), p.baseline_deviation,
          q.baseline_deviation);
  return most;
}

// Every subset of two poses either agrees with all three within its stated deviations or is refused. Returns how it
// fits, and how it explains the pose left out, with the chessboard's shape released and without.
nlohmann::ordered_json subsets(const RealChessboard& real) {
  constexpr double kWithin = 3;  // standard deviations, for the greatest of 15 differences
  calibration::CalibrateSettings settings = real.settings;
  nlohmann::ordered_json results;
  const calibration::CalibrationReport all = calibration::calibrate(real.homography, settings);
  EXPECT_EQ(all.model.refusal, "");
  for (int left_out = 0; left_out < kPoses; ++left_out) {
    std::vector<calibration::PoseReport> subset = real.homography;
    subset.erase(subset.begin() + left_out);
    for (const bool bent : {true, false}) {
      settings.bent = bent;
      const calibration::CalibrationReport report = calibration::calibrate(subset, settings);
      const calibration::CheckReport check =
          calibration::check_pose(real.homography[static_cast<std::size_t>(left_out)], report);
      const double off = farthest(report, all);
      if (bent && report.model.refusal.empty()) {
        EXPECT_LT(off, kWithin) << "without pose " << left_out;
      }
      results["without_" + std::to_string(left_out)][bent ? "bent" : "flat"] = {
          {"refused", !report.model.refusal.empty()},
          {"camera_focal_px", report.calibration.camera.fx},
          {"camera_focal_deviation_px", report.bundle.deviation.camera[0]},
          {"farthest_deviations", off},
          {"held_out_camera_rms_px", check.camera_rms},
          {"held_out_projector_rms_px", check.projector_rms},
          {"held_out_size_off", check.scale},
          {"held_out_points_rms_mm", check.point_rms_mm}};
    }
  }
  return results;
}

TEST(RealCalibration, ThreePosesOfAChessboard) {
  if (!fs::exists(folder_of(0))) {
    GTEST_SKIP() << "no " << folder_of(0);
  }
  const RealChessboard real;
  nlohmann::ordered_json results = three_poses(real);
  results["subsets"] = subsets(real);
  std::printf("%s\n", results.dump(1).c_str());
  files::write_results("real_calibration", "Camera and projector from real captures of a chessboard in three poses",
                       results);
}

// However the camera is turned, the chessboard is the same one.
TEST(RealCalibration, TurnedCamerasFindTheChessboard) {
  if (!fs::exists(folder_of(0))) {
    GTEST_SKIP() << "no " << folder_of(0);
  }
  const calibration::Chessboard chessboard{9, 7, 75};
  for (int pose = 0; pose < kPoses; ++pose) {
    images::Image image = images::read_image(images::files_of_folder(folder_of(pose)).at(40), {});  // all white
    const calibration::FoundChessboard upright = calibration::find_chessboard(image, chessboard);
    ASSERT_EQ(upright.reason, "");
    for (int quarter = 1; quarter < 4; ++quarter) {
      images::Image turned{image.columns, image.rows, {}};  // by 90 degrees against the clock
      for (int column = image.columns - 1; column >= 0; --column) {
        for (int row = 0; row < image.rows; ++row) {
          turned.pixels.push_back(image.view().pixels[row * image.columns + column]);
        }
      }
      image = std::move(turned);
      const calibration::FoundChessboard found = calibration::find_chessboard(image, chessboard);
      EXPECT_EQ(found.reason, "") << "pose " << pose << ", turned by " << 90 * quarter;
      EXPECT_NEAR(found.spacing_px, upright.spacing_px, 0.1);
    }
  }
}

#ifdef SELFPROJ_HAS_OPENCV_STRUCTURED_LIGHT

// OpenCV's white threshold is one above ours, because it accepts a difference equal to its threshold.
TEST(RealCalibration, ProjectorPixelsAreThoseOfOpenCv) {
  if (!fs::exists(folder_of(0))) {
    GTEST_SKIP() << "no " << folder_of(0);
  }
  const calibration::DecodeSettings settings;
  const auto peer = cv::structured_light::GrayCodePattern::create(kSequence.columns(), kSequence.rows());
  peer->setWhiteThreshold(static_cast<std::size_t>(settings.threshold) + 1);
  for (int pose = 0; pose < kPoses; ++pose) {
    const calibration::Capture capture = capture_of(pose, settings);
    std::vector<images::Image> images;
    std::vector<cv::Mat> mats;
    for (const std::string& file : images::files_of_folder(folder_of(pose))) {
      images.push_back(images::read_image(file, {}));
    }
    for (images::Image& image : images) {
      mats.emplace_back(image.rows, image.columns, CV_8UC1, image.pixels.data());
    }
    mats.resize(peer->getNumberOfPatternImages());
    std::size_t both = 0;
    std::size_t ours = 0;
    std::size_t theirs = 0;
    std::size_t i = 0;
    for (int y = 0; y < capture.rows; ++y) {
      for (int x = 0; x < capture.columns; ++x, ++i) {
        cv::Point pixel;
        const bool their = !peer->getProjPixel(mats, x, y, pixel);
        const bool our = capture.projector_column[i] != calibration::Capture::kNone;
        theirs += their && !our ? 1 : 0;
        ours += our && !their ? 1 : 0;
        if (our && their) {
          ++both;
          ASSERT_EQ(pixel.x, capture.projector_column[i]) << x << ", " << y;
          ASSERT_EQ(pixel.y, capture.projector_row[i]) << x << ", " << y;
        }
      }
    }
    std::printf("pose %d: %zu pixels valid in both, all equal; %zu here only, %zu there only (contrast)\n", pose, both,
                ours, theirs);
    EXPECT_GT(both, i / 3);
    EXPECT_EQ(ours, 0U);
  }
}

#else

TEST(RealCalibration, ProjectorPixelsAreThoseOfOpenCv) {
  GTEST_SKIP() << "built without OpenCV's structured_light module (libopencv-contrib-dev)";
}

#endif

}  // namespace
}  // namespace selfproj::test
