// Least squares over all unknowns together: both lenses, the pose between them, and the pose of the chessboard in every
// capture.
#ifndef SELFPROJ_HOST_CALIBRATION_BUNDLE_H
#define SELFPROJ_HOST_CALIBRATION_BUNDLE_H

#include <array>
#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace selfproj {

// One corner of the chessboard as camera and projector see it.
struct Sight {
  int corner = 0;          // its number on the chessboard
  cv::Point3d chessboard;  // where it is on the chessboard: mm, z = 0
  cv::Point2d camera;      // column, row
  cv::Point2d projector;   // column, row
};

struct View {
  std::vector<Sight> sights;
};

// fx, fy, cx, cy, k1, k2, p1, p2, k3 of OpenCV's model (host/rig/lens.h).
inline constexpr std::size_t kLensParameters = 9;
using LensParameters = std::array<double, kLensParameters>;

// How many of k1, k2, p1, p2, k3 are estimated, in this order; the others keep their values.
struct FreeDistortion {
  int camera = 2;
  int projector = 2;
};

struct Pose {
  cv::Vec3d rotation;     // Rodrigues vector, rad
  cv::Vec3d translation;  // mm
};

struct Bundle {
  LensParameters camera{}, projector{};
  Pose stereo;                   // projector from camera
  std::vector<Pose> chessboard;  // camera from chessboard, one for each view
};

struct BundleResult {
  Bundle bundle;
  // Standard deviations in the same layout; infinite if the data say nothing about a parameter.
  Bundle deviation;
  double baseline_deviation = 0;  // of the length of the translation, in mm
  // Root mean square of the lengths of the residuals in pixels: over all views, and for each view.
  double camera_rms = 0, projector_rms = 0, rms = 0;
  std::vector<double> view_camera_rms, view_projector_rms;
  // Residuals (seen less computed) of each view's sights, in order.
  std::vector<std::vector<cv::Vec2d>> camera_residuals, projector_residuals;
};

// Levenberg-Marquardt from a start. The residuals of camera and projector are each weighted by their own variance,
// which is estimated with them. Throws std::invalid_argument if there are fewer equations than unknowns, and
// std::runtime_error if the sum of squares is not finite.
BundleResult solve_bundle(const std::vector<View>& views, const Bundle& start, const FreeDistortion& free);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_BUNDLE_H
