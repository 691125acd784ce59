// How well a calibration explains a pose of the chessboard that took no part in it.
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATION_CHECK_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATION_CHECK_H

#include "host/calibration/calibration_report.h"

namespace selfproj {

// Fits nothing but the place of a pose that took no part, and compares what is seen there with the calibration. What
// cannot be used is no error: the result has a reason.
CheckReport check_pose(const PoseReport& pose, const CalibrationReport& report);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATION_CHECK_H
