// What the least squares of a calibration take and give: both lenses, the pose between them, the pose of the chessboard
// in every capture, and the chessboard's shape.
#ifndef SELFPROJ_HOST_CALIBRATION_BUNDLE_H
#define SELFPROJ_HOST_CALIBRATION_BUNDLE_H

#include <algorithm>
#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "host/calibration/chessboard.h"
#include "selfproj/rig/calibration.h"

namespace selfproj::calibration {

// One corner of the chessboard as camera and projector see it.
struct Sight {
  int corner = 0;          // its number on the chessboard
  cv::Point3d chessboard;  // where it is on the drawing: mm, z = 0
  cv::Point2d camera;      // column, row
  cv::Point2d projector;   // column, row
};

struct View {
  std::vector<Sight> sights;
};

// The longer side of what the views see of the drawn chessboard, mm.
inline double board_side(const std::vector<View>& views) {
  double greatest = 0;
  for (const View& view : views) {
    for (const Sight& sight : view.sights) {
      greatest = std::max({greatest, sight.chessboard.x, sight.chessboard.y});
    }
  }
  return greatest;
}

// fx, fy, cx, cy, k1, k2, p1, p2, k3 of OpenCV's model (include/selfproj/rig/calibration.h).
inline constexpr std::size_t kLensParameters = 9;
inline constexpr int kPinholeParameters = 4;  // of them, those before the distortion
using LensParameters = std::array<double, kLensParameters>;
inline constexpr std::array<const char*, kLensParameters> kLensNames{"fx", "fy", "cx", "cy", "k1",
                                                                     "k2", "p1", "p2", "k3"};
inline rig::Lens lens_of(const LensParameters& p) {
  return {p[0], p[1], p[2], p[3], {p[4], p[5], p[6], p[7], p[8], 0, 0, 0}};
}

// How many of k1, k2, p1, p2, k3 are estimated, in this order; the others keep their values. As a setting of a whole
// calibration, kByData leaves the number to the data.
struct FreeDistortion {
  static constexpr int kByData = -1;

  int camera = kByData;
  int projector = kByData;
};

inline constexpr int kPoseParameters = 6;
struct Pose {
  cv::Vec3d rotation;     // Rodrigues vector, rad
  cv::Vec3d translation;  // mm
};

// The standard deviations of what is random: the corners' places in the images, pixels along one direction, and the
// size of the modes of the chessboard's shape (CornerModes), mm.
struct BundleNoise {
  double camera = 0.1;
  double projector = 0.1;
  double bend = 0;     // shared by all poses
  double stretch = 0;  // shared by all poses, within the plane
  double own = 0;      // bend of a single pose beside the shared one
};

struct Plates;  // plates.h

// How plates lie over a belt, in the axes of a chessboard on the plate at height 0 with the belt at place 0: x and y
// along the chessboard, z away from the camera.
struct Belt {
  Pose pose;                                       // camera from these axes
  cv::Vec2d way{0, 1};                             // x and y by which a millimetre of the belt moves the chessboard
  double scale = 0;                                // of the chessboard's squares, in units of Plates::scale_deviation
  std::vector<std::array<double, 6>> plate_off{};  // of each plate from its drawing, in units of Plates::deviations
};

struct Bundle {
  LensParameters camera{}, projector{};
  Pose stereo;                                          // projector from camera
  std::vector<Pose> chessboard;                         // camera from chessboard, one for each view
  std::array<double, kSharedModes> shape{};             // in units of noise.bend and noise.stretch
  std::vector<std::array<double, kOwnModes>> own_bend;  // one for each view, in units of noise.own
  BundleNoise noise;
  Belt belt;  // only with BundleOptions::plates
};

struct BundleOptions {
  FreeDistortion free{0, 0};
  FreeDistortion uncertain{0, 0};  // coefficients beyond the free ones that are held, but not known to be 0
  const std::vector<CornerModes>* shape = nullptr;  // of the chessboard; none: it is flat
  const Plates* plates = nullptr;                   // under the chessboards; none: nothing is known of their places
  bool projector = true;                            // false: the camera alone; projector and stereo keep their values
  bool estimate_noise = true;                       // false: it stays that of the start
  bool deviations = true;  // false: none are computed, and the minimum is rough, which is faster
};

struct BundleResult {
  Bundle bundle;
  // Half the sum of squares of all residuals over their standard deviations, those of the shape's modes included.
  double cost = 0;
  // Standard deviations in the same layout; infinite if the data say nothing about a parameter. Those of the shape are
  // not filled in. Widened for few views (widening_of in bundle_covariance.h).
  Bundle deviation;
  double baseline_deviation = 0;  // of the length of the translation, in mm
  // With plates: of the angle between the plates' normal and what the camera sees in the middle of its image, rad, and
  // of Belt::scale.
  double lean_deviation = 0, scale_deviation = 0;
  // Of the free distortion coefficients, camera before projector, unwidened.
  cv::Mat1d distortion_covariance;
  // Root mean square of the lengths of the residuals in pixels: over all views, and for each view.
  double camera_rms = 0, projector_rms = 0, rms = 0;
  std::vector<double> view_camera_rms, view_projector_rms;
  // Residuals (seen less computed) of each view's sights, in order.
  std::vector<std::vector<cv::Vec2d>> camera_residuals, projector_residuals;
};

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_BUNDLE_H
