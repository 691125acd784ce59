// Calibration of projector and camera from captures of a chessboard in several poses (docs/calibration.md): settings,
// observations, result, and how well it explains poses that took no part in it.
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATE_H

#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/capture.h"
#include "host/calibration/chessboard.h"
#include "host/calibration/model_choice.h"
#include "host/calibration/plates.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/rig/rig.h"

namespace selfproj::calibration {

struct CalibrateSettings {
  Chessboard chessboard;
  int projector_columns = 0;
  int projector_rows = 0;
  CornerSettings corners;
  int min_corners = 12;  // a pose with fewer usable corners is left out
  FreeDistortion free;   // 0, 1, 2, 4 or 5 for each lens, or FreeDistortion::kByData
  bool bent = true;      // the chessboard's shape is estimated; false: it is exactly flat
  // Under the chessboards of the first poses, if there are any; the projector's rows count as in the images.
  std::optional<Plates> plates;
  double reject = 4.5;  // corners with residuals above this many standard deviations are left out; 0: none
};

struct Corner {
  cv::Point2d camera, projector;  // column, row; projector NaN if it was not found
  double sd_px = 0;               // estimated for the projector
  bool used = false;
  std::string reason;                             // why it is not used
  cv::Vec2d camera_residual, projector_residual;  // seen less computed, of used corners
};

// One pose of the chessboard, in the given order.
struct PoseReport {
  std::string name;
  std::string reason;  // why the whole pose is left out; empty if it is used
  int rows = 0;        // rows of the camera
  int columns = 0;
  double decoded_share = 0;     // share of the camera's pixels that have a code
  bool by_squares = false;      // its chessboard was found so (chessboard.h)
  double lit_share = 1;         // share of those around the corners in which white is brighter than black
  std::vector<Corner> corners;  // all of the chessboard's corners, or none if it was not seen
  double angle_deg = 0;         // angle between the chessboard's normal and the camera's axis
  double camera_rms = 0, projector_rms = 0;

  [[nodiscard]] int used() const;
};

// How a pose that took no part in the calibration fits it.
struct CheckReport {
  std::string name;
  std::string reason;  // why it cannot be used; empty if it can
  int corners = 0;
  double camera_rms = 0, projector_rms = 0;  // px, the pose being all that is fitted
  double scale = 0;                          // size of the triangulated chessboard over the true size, less 1
  double point_rms_mm = 0;                   // triangulated corners off the chessboard that fits them best
};

struct CalibrationReport {
  CalibrateSettings settings;
  std::vector<PoseReport> poses;
  rig::Calibration calibration;  // with the sizes of camera and projector
  // The projector shows its image mirrored (seen from the front, columns run right and rows up, or the reverse). Its fy
  // is then negative.
  bool mirrored = false;
  BundleResult bundle;             // of the used poses, in order; if mirrored, the projector's rows count from below
  ModelChoice model;               // how that was chosen; its own result is `bundle`
  std::vector<CornerModes> shape;  // of the chessboard; empty if it is flat
  std::optional<BeltReport> belt;  // if there were plates
  double board_range_mm = 0;       // highest less lowest corner of the shared shape
  double camera_alone_rms = 0, projector_alone_rms = 0;  // each lens calibrated without the other
  double max_angle_deg = 0;                              // between two poses' normals
  double camera_coverage = 0, projector_coverage = 0;    // share of the image within the hull of all used corners
  double mean_distance_mm = 0;                           // of the used corners, along the camera's axis
  std::vector<CheckReport> checks;
  std::vector<std::string> warnings;
};

// Finds the corners of the chessboard in the camera's image, and the projector pixel that lights each corner. If the
// chessboard or a corner is not found, that is no error: its `reason` says why.
PoseReport observe_pose(const std::string& name, const Capture& capture, const CalibrateSettings& settings);

// The corners of a pose that the least-squares fit uses. If the projector is mirrored, its rows count from below.
View view_of(const PoseReport& pose, const CalibrateSettings& settings, bool mirrored);

// Fits both lenses and all poses at once by least squares, with the lens model that the captures support. Removes
// corners with too long residuals and fits again, until no residual is too long. Throws UserError if fewer than two
// poses can be used (with the reason for each pose), if images differ in size, or if nothing converges. If the result
// must not be used, report.model.refusal says why.
CalibrationReport calibrate(std::vector<PoseReport> poses, const CalibrateSettings& settings);

// Fits nothing but the place of a pose that took no part, and compares what is seen there with the calibration. What
// cannot be used is no error: the result has a reason.
CheckReport check_pose(const PoseReport& pose, const CalibrationReport& report);

// One sentence for each number of a finished calibration that the captures do not constrain well. The limits are in
// docs/calibration.md. Empty if all is well.
std::vector<std::string> warnings_of(const CalibrationReport& report);

// The rig of a calibration: `drawn` with its lenses, and with the belt if there were plates. A scanner's limit of z for
// a line is widened to what the calibrated rig needs. Throws std::invalid_argument as rig_of
// (include/selfproj/rig/calibration.h) does.
rig::Rig calibrated_rig(const CalibrationReport& report, const rig::Rig& drawn);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
