// Calibrates from captures made by others (../shared/data, not part of the project): a chessboard in three poses.
// Reports that it is skipped if they, or OpenCV's structured_light module, are missing.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "host/calibration/calibrate.h"
#include "host/calibration/capture.h"
#include "host/io/image_files.h"
#include "host/io/results_file.h"
#include "host/structured_light/gray_sequence.h"

#ifdef SELFPROJ_HAS_OPENCV_STRUCTURED_LIGHT
#include <opencv2/structured_light/graycodepattern.hpp>
#endif

namespace selfproj {
namespace {

namespace fs = std::filesystem;

constexpr int kPoses = 3;
const GraySequence kSequence(1024, 768);

std::string folder_of(int pose) {
  const fs::path data = fs::path(SELFPROJ_SOURCE_DIR) / "../shared/data";
  return (data / ("gray-kamino-pose" + std::to_string(pose)) / ("capture_" + std::to_string(pose))).string();
}

Capture capture_of(int pose, const DecodeSettings& settings) {
  const std::string folder = folder_of(pose);
  return decode_capture(folder, files_of_folder(folder), kSequence, settings, {});
}

TEST(RealCalibration, ThreePosesOfAChessboard) {
  if (!fs::exists(folder_of(0))) {
    GTEST_SKIP() << "no " << folder_of(0);
  }
  std::vector<Capture> captures;
  for (int pose = 0; pose < kPoses; ++pose) {
    captures.push_back(capture_of(pose, {}));
  }
  CalibrateSettings settings;
  settings.chessboard = {9, 7, 75};
  settings.projector_columns = kSequence.columns();
  settings.projector_rows = kSequence.rows();
  nlohmann::ordered_json results;
  for (const CornerMethod method : {CornerMethod::homography, CornerMethod::direct}) {
    settings.corners.method = method;
    std::vector<PoseReport> poses;
    for (int pose = 0; pose < kPoses; ++pose) {
      poses.push_back(observe_pose(folder_of(pose), captures[static_cast<std::size_t>(pose)], settings));
      EXPECT_EQ(poses.back().used(), settings.chessboard.corners());
    }
    for (const double reject : {0.0, 4.5}) {
      settings.reject = reject;
      const CalibrationReport report = calibrate(poses, settings);
      const BundleResult& found = report.bundle;
      int used = 0;
      for (const PoseReport& pose : report.poses) {
        used += pose.used();
      }
      std::printf(
          "%s, %s: %d corners, camera f %.1f +- %.1f px, projector f %.1f +- %.1f px, baseline %.2f +- %.2f, RMS "
          "camera %.3f, projector %.3f, stereo %.3f px\n",
          method == CornerMethod::homography ? "homography" : "direct", reject > 0 ? "rejecting" : "all corners", used,
          report.calibration.camera.fx, found.deviation.camera[0], report.calibration.projector.fx,
          found.deviation.projector[0], cv::norm(report.calibration.translation), found.baseline_deviation,
          found.camera_rms, found.projector_rms, found.rms);
      constexpr double kFocal = 3452;  // that of five poses
      results[method == CornerMethod::homography ? "homography" : "direct"][reject > 0 ? "rejecting" : "all_corners"] =
          {{"corners", used},
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
      for (std::size_t i = 0; i < kLensParameters; ++i) {
        const bool estimated = i < 4 + static_cast<std::size_t>(settings.free.camera);
        EXPECT_EQ(found.deviation.camera[i] > 0 && std::isfinite(found.deviation.camera[i]), estimated) << i;
        EXPECT_EQ(found.deviation.projector[i] > 0 && std::isfinite(found.deviation.projector[i]), estimated) << i;
      }
      EXPECT_GE(used, reject > 0 ? 150 : 3 * 63);
      // The corners lie only in the middle of both images.
      const auto covers = [](const std::string& warning) {
        return warning.find("corners cover only") != std::string::npos;
      };
      EXPECT_EQ(std::count_if(report.warnings.begin(), report.warnings.end(), covers), 2);
    }
  }
  write_results("real_calibration", "Camera and projector from real captures of a chessboard in three poses", results);
}

#ifdef SELFPROJ_HAS_OPENCV_STRUCTURED_LIGHT

// OpenCV's white threshold is one above ours, because it accepts a difference equal to its threshold.
TEST(RealCalibration, ProjectorPixelsAreThoseOfOpenCv) {
  if (!fs::exists(folder_of(0))) {
    GTEST_SKIP() << "no " << folder_of(0);
  }
  const DecodeSettings settings;
  const auto peer = cv::structured_light::GrayCodePattern::create(kSequence.columns(), kSequence.rows());
  peer->setWhiteThreshold(static_cast<std::size_t>(settings.threshold) + 1);
  for (int pose = 0; pose < kPoses; ++pose) {
    const Capture capture = capture_of(pose, settings);
    std::vector<Image> images;
    std::vector<cv::Mat> mats;
    for (const std::string& file : files_of_folder(folder_of(pose))) {
      images.push_back(read_image(file, {}));
    }
    for (Image& image : images) {
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
        const bool our = capture.projector_column[i] != Capture::kNone;
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
}  // namespace selfproj
