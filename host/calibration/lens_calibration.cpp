#include "host/calibration/lens_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <vector>

#include "host/io/stderr_capture.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace {

int flags_of(int free) {
  int flags = 0;
  flags |= free < 1 ? cv::CALIB_FIX_K1 : 0;
  flags |= free < 2 ? cv::CALIB_FIX_K2 : 0;
  flags |= free < 4 ? cv::CALIB_ZERO_TANGENT_DIST : 0;
  flags |= free < 5 ? cv::CALIB_FIX_K3 : 0;
  return flags;
}

}  // namespace

LensCalibration calibrate_lens(const std::vector<View>& views, cv::Size size, int free, cv::Point2d Sight::*place) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> seen;
  for (const View& view : views) {
    points.emplace_back();
    seen.emplace_back();
    for (const Sight& sight : view.sights) {
      points.back().emplace_back(sight.chessboard);
      seen.back().emplace_back(sight.*place);
    }
  }
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-10);
  // Parallel poses say nothing about the focal length, and the closed form may then give anything. In this case the
  // least squares start from a usual lens.
  for (const bool guess : {false, true}) {
    const double usual = 1.2 * std::max(size.width, size.height);
    cv::Mat matrix = (cv::Mat_<double>(3, 3) << usual, 0, 0.5 * (size.width - 1), 0, usual, 0.5 * (size.height - 1), 0,
                      0, 1);  // NOLINT: OpenCV's way
    cv::Mat distortion = cv::Mat::zeros(5, 1, CV_64F);
    std::vector<cv::Vec3d> rotations;
    std::vector<cv::Vec3d> translations;
    LensCalibration result;
    try {
      const StderrCapture capture;
      result.rms = cv::calibrateCamera(points, seen, size, matrix, distortion, rotations, translations,
                                       flags_of(free) | (guess ? cv::CALIB_USE_INTRINSIC_GUESS : 0), until);
    } catch (const cv::Exception&) {
      continue;
    }
    result.lens = {matrix.at<double>(0, 0),  matrix.at<double>(1, 1),  matrix.at<double>(0, 2),
                   matrix.at<double>(1, 2),  distortion.at<double>(0), distortion.at<double>(1),
                   distortion.at<double>(2), distortion.at<double>(3), distortion.at<double>(4)};
    for (std::size_t i = 0; i < rotations.size(); ++i) {
      result.chessboard.push_back({rotations[i], translations[i]});
    }
    const bool finite = std::all_of(result.lens.begin(), result.lens.end(), [](double v) { return std::isfinite(v); });
    constexpr double kSane = 1000;
    if (finite && result.lens[0] > 0 && result.lens[1] > 0 && result.lens[0] < kSane * usual) {
      return result;
    }
  }
  throw UserError("calibrate", "the poses do not determine the lens; lean the chessboard in more directions");
}

Pose stereo_pose(const LensCalibration& camera, const LensCalibration& projector) {
  std::vector<Pose> all;
  for (std::size_t i = 0; i < camera.chessboard.size(); ++i) {
    cv::Matx33d rc;
    cv::Matx33d rp;
    cv::Rodrigues(camera.chessboard[i].rotation, rc);
    cv::Rodrigues(projector.chessboard[i].rotation, rp);
    const cv::Matx33d r = rp * rc.t();
    Pose pose;
    cv::Rodrigues(r, pose.rotation);
    pose.translation = projector.chessboard[i].translation - r * camera.chessboard[i].translation;
    all.push_back(pose);
  }
  const auto off = [&](const Pose& pose) {
    double sum = 0;
    for (const Pose& other : all) {
      sum += cv::norm(pose.rotation - other.rotation) +
             cv::norm(pose.translation - other.translation) / (1 + cv::norm(other.translation));
    }
    return sum;
  };
  return *std::min_element(all.begin(), all.end(), [&](const Pose& a, const Pose& b) { return off(a) < off(b); });
}

}  // namespace selfproj
