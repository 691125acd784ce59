// Calibration of projector and camera from captures of a chessboard in several poses (method, section 6).
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATE_H

#include <string>
#include <vector>

#include "host/calibration/calibration_report.h"
#include "host/calibration/capture.h"

namespace selfproj {

// Finds the chessboard in a capture and its corners in the projector. Does not throw for what it does not find.
PoseReport observe_pose(const std::string& name, const Capture& capture, const CalibrateSettings& settings);

// Zhang's method for camera and projector, then both with the pose between them by least squares over everything, from
// which corners with too long residuals are taken out until none is left. Throws UserError where fewer than two poses
// can be used (naming each pose's reason), images differ in size, or nothing converges.
CalibrationReport calibrate(std::vector<PoseReport> poses, const CalibrateSettings& settings);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATE_H
