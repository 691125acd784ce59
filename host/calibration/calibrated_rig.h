// From the drawings of a rig to the rig that a calibration gives.
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATED_RIG_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATED_RIG_H

#include <vector>

#include "host/calibration/bundle_plates.h"
#include "host/calibration/calibration_report.h"
#include "host/calibration/chessboard.h"
#include "host/rig/rig.h"

namespace selfproj {

// Plates over the belt of a rig (CalibrateSettings::plates), whose lenses, poses and distance are where the least
// squares start. Heights and places of the belt are in mm, ascending; `tolerances` gives the two of DrawnScale, and the
// rig the rest of it.
Plates plates_over(const Rig& rig, const Chessboard& chessboard, const std::vector<double>& heights_mm,
                   const std::vector<double>& belt_mm, const PlateTolerance& tolerance, const DrawnScale& tolerances);

// The rig of a calibration: `drawn` with its lenses, and with the belt if there were plates. A scanner's limit of z for
// a line is widened to what the calibrated rig needs. Throws std::invalid_argument as rig_of (rig_calibration.h) does.
Rig calibrated_rig(const CalibrationReport& report, const Rig& drawn);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATED_RIG_H
