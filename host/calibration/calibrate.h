// Calibration of projector and camera from captures of a chessboard in several poses (docs/calibration.md).
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATE_H

#include <string>
#include <vector>

#include "host/calibration/calibration_report.h"
#include "host/calibration/capture.h"

namespace selfproj {

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

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
