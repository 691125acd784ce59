// What `selfproj calibrate` leaves behind (README.md beside this file has the files).
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATION_OUTPUT_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATION_OUTPUT_H

#include <string>

#include "host/calibration/calibration_report.h"

namespace selfproj {

// The corners of camera and projector in their images, coloured by pose, those left out crossed; with their hull. PNG.
std::string coverage_picture(const CalibrationReport& report);

// Above, the residuals of camera and projector as points in pixels; below, as arrows, magnified, where they are. PNG.
std::string residual_picture(const CalibrationReport& report);

// pose,corner,x,y,u,v,sd,used,dx,dy,du,dv,reason: a line a corner.
std::string corner_table(const CalibrationReport& report);

// Everything that is known of the calibration, with standard deviations, as JSON.
std::string report_json(const CalibrationReport& report);

// The same for a reader, lines of at most about 110 characters.
std::string report_text(const CalibrationReport& report);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATION_OUTPUT_H
