// Calibration of projector and camera from captures of a chessboard in several poses (method, section 6).
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATE_H

#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/capture.h"
#include "host/calibration/chessboard.h"
#include "host/calibration/corner_codes.h"
#include "host/rig/calibration_file.h"

namespace selfproj {

struct CalibrateSettings {
  Chessboard board;
  int projector_columns = 0;
  int projector_rows = 0;
  CornerSettings corners;
  int min_corners = 12;  // a pose with fewer usable ones is left out
  FreeDistortion free;   // each 0, 1, 2, 4 or 5
  double reject = 4.5;   // corners whose residual is longer than so many standard deviations are left out; 0: none
};

struct Corner {
  cv::Point2d camera, projector;  // column, row; projector NaN where it has not been found
  double sd_px = 0;               // of the projector's, estimated
  bool used = false;
  std::string reason;                             // why it is not used
  cv::Vec2d camera_residual, projector_residual;  // seen less computed, of used ones
};

// One pose of the board, in the order given.
struct PoseReport {
  std::string name;
  std::string reason;  // why the whole pose is left out; empty where it is used
  int rows = 0;        // of the camera
  int columns = 0;
  double decoded_share = 0;     // of the camera's pixels
  std::vector<Corner> corners;  // all of the board's, or none where it is not seen
  double angle_deg = 0;         // between the board's normal and the camera's axis
  double camera_rms = 0, projector_rms = 0;

  [[nodiscard]] int used() const;
};

// Finds the board in a capture and its corners in the projector. Does not throw for what it does not find.
PoseReport observe_pose(const std::string& name, const Capture& capture, const CalibrateSettings& settings);

struct CalibrationReport {
  CalibrateSettings settings;
  std::vector<PoseReport> poses;
  Calibration calibration;  // with the sizes of camera and projector
  // The projector shows its image mirrored (seen from the front, columns run right and rows up, or the reverse): its
  // fy is then negative.
  bool mirrored = false;
  BundleResult bundle;  // of the used poses, in their order; the projector's rows counted from below where mirrored
  double camera_alone_rms = 0, projector_alone_rms = 0;  // each calibrated without the other
  double greatest_angle_deg = 0;                         // between two poses' normals
  double camera_coverage = 0, projector_coverage = 0;    // share of the image within the hull of all used corners
  double mean_distance_mm = 0;                           // of the used corners along the camera's axis
  std::vector<std::string> warnings;
};

// Zhang's method for camera and projector, then both with the pose between them by least squares over everything, from
// which corners with too long residuals are taken out until none is left. Throws UserError where fewer than two poses
// can be used (naming each pose's reason), images differ in size, or nothing converges.
CalibrationReport calibrate(std::vector<PoseReport> poses, const CalibrateSettings& settings);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
