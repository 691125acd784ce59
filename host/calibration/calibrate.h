// Calibration of projector and camera from captures of a chessboard in several poses (method, section 6).
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATE_H

#include <string>
#include <vector>

#include "host/calibration/calibration_report.h"
#include "host/calibration/capture.h"

namespace selfproj {

// Finds the chessboard in a capture and its corners in the projector. Corners that it does not find are not an error.
PoseReport observe_pose(const std::string& name, const Capture& capture, const CalibrateSettings& settings);

// The used corners of a pose, for the least squares. Rows of a mirrored projector count from below.
View view_of(const PoseReport& pose, const CalibrateSettings& settings, bool mirrored);

// Least squares over everything, with the lens model that the captures support. Corners with too long residuals are
// removed until none is left. Throws UserError if fewer than two poses can be used (with the reason for each pose), if
// images differ in size, or if nothing converges. A result that must not be used has report.model.refusal.
CalibrationReport calibrate(std::vector<PoseReport> poses, const CalibrateSettings& settings);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
