// The files of `selfproj calibrate` (docs/calibration.md lists them).
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATION_OUTPUT_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATION_OUTPUT_H

#include <string>

#include "host/calibration/calibrate.h"

namespace selfproj::calibration {

// One line for each corner: pose,corner,x,y,u,v,sd,used,dx,dy,du,dv,reason.
std::string corner_table(const CalibrationReport& report);

// All findings of the calibration with standard deviations, as JSON.
std::string report_json(const CalibrationReport& report);

// The same for a human reader, in lines of at most about 110 characters.
std::string report_text(const CalibrationReport& report);

// PNG: the corners of camera and projector in their images, coloured by pose, with their hull; unused ones are crossed.
std::string coverage_picture(const CalibrationReport& report);

// PNG: the residuals of camera and projector, above as points in pixels, below as magnified arrows in place.
std::string residual_picture(const CalibrationReport& report);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATION_OUTPUT_H
