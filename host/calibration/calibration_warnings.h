// Warnings about parameters that the captures do not determine.
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATION_WARNINGS_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATION_WARNINGS_H

#include <string>
#include <vector>

#include "host/calibration/calibration_report.h"

namespace selfproj {

// One sentence for each number of a finished calibration that the captures do not constrain well. The limits are in
// docs/calibration.md. Empty if all is well.
std::vector<std::string> warnings_of(const CalibrationReport& report);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATION_WARNINGS_H
