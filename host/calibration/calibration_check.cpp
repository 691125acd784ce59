#include "host/calibration/calibration_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/calibrate.h"
#include "host/calibration/starts.h"

namespace selfproj {
namespace {

// The point halfway between a camera pixel's ray and a projector pixel's, in the camera's frame; nothing if a lens has
// no ray for its pixel.
std::optional<cv::Vec3d> triangulated(const Calibration& c, const Corner& corner) {
  const std::optional<cv::Vec2d> in_camera = c.camera.ray({corner.camera.x, corner.camera.y});
  const std::optional<cv::Vec2d> in_projector = c.projector.ray({corner.projector.x, corner.projector.y});
  if (!in_camera || !in_projector) {
    return std::nullopt;
  }
  const cv::Vec3d a((*in_camera)[0], (*in_camera)[1], 1);
  const cv::Vec3d b = c.rotation.t() * cv::Vec3d((*in_projector)[0], (*in_projector)[1], 1);
  const cv::Vec3d from = -(c.rotation.t() * c.translation);  // the projector's place
  const cv::Matx22d normal(a.dot(a), -a.dot(b), -a.dot(b), b.dot(b));
  const cv::Vec2d along = normal.inv() * cv::Vec2d(a.dot(from), -b.dot(from));
  return 0.5 * (along[0] * a + from + along[1] * b);
}

// Compares the triangulated corners with the chessboard, whose scale is free.
void measure(const PoseReport& pose, const View& view, const CalibrationReport& report, CheckReport& check) {
  const std::vector<CornerModes>* shape = report.shape.empty() ? nullptr : &report.shape;
  Eigen::Matrix3Xd on_board(3, static_cast<Eigen::Index>(view.sights.size()));
  Eigen::Matrix3Xd seen(3, on_board.cols());
  Eigen::Index count = 0;
  for (const Sight& sight : view.sights) {
    const auto point = triangulated(report.calibration, pose.corners[static_cast<std::size_t>(sight.corner)]);
    if (point) {
      const cv::Vec3d place = place_on_board(sight, report.bundle.bundle, shape);
      on_board.col(count) << place[0], place[1], place[2];
      seen.col(count++) << (*point)[0], (*point)[1], (*point)[2];
    }
  }
  constexpr Eigen::Index kLeast = 4;
  if (count < kLeast) {
    check.reason = "too few of its corners can be triangulated";
    return;
  }
  on_board.conservativeResize(3, count);
  seen.conservativeResize(3, count);
  const Eigen::Matrix4d map = Eigen::umeyama(on_board, seen, true);
  const Eigen::Matrix3Xd off =
      seen - ((map.topLeftCorner<3, 3>() * on_board).colwise() + map.topRightCorner<3, 1>()).eval();
  check.scale = map.topLeftCorner<3, 1>().norm() - 1;
  check.point_rms_mm = std::sqrt(off.squaredNorm() / static_cast<double>(count));
}

}  // namespace

CheckReport check_pose(const PoseReport& pose, const CalibrationReport& report) {
  CheckReport check;
  check.name = pose.name;
  check.corners = pose.used();
  check.reason = pose.reason;
  if (check.reason.empty() &&
      (pose.rows != report.calibration.camera_rows || pose.columns != report.calibration.camera_columns)) {
    check.reason = "its images have another size";
  }
  if (check.reason.empty() && check.corners < report.settings.min_corners) {
    check.reason = "too few of its corners can be used";
  }
  if (!check.reason.empty()) {
    return check;
  }
  const std::vector<CornerModes>* shape = report.shape.empty() ? nullptr : &report.shape;
  const View view = view_of(pose, report.settings, report.mirrored);
  try {
    const Pose start = chessboard_pose(view, report.bundle.bundle.camera);
    if (!(start.translation[2] > 0)) {
      throw std::runtime_error("no pose of the chessboard explains its corners");
    }
    const BundleResult found = locate_view(view, report.bundle.bundle, start, shape);
    check.camera_rms = found.camera_rms;
    check.projector_rms = found.projector_rms;
    measure(pose, view, report, check);
  } catch (const std::runtime_error& error) {
    check.reason = error.what();
  }
  return check;
}

}  // namespace selfproj
