// The pictures that `selfproj calibrate` writes.
#ifndef SELFPROJ_HOST_CALIBRATION_CALIBRATION_PICTURES_H
#define SELFPROJ_HOST_CALIBRATION_CALIBRATION_PICTURES_H

#include <string>

#include "host/calibration/calibration_report.h"

namespace selfproj {

// PNG: the corners of camera and projector in their images, coloured by pose, with their hull; unused ones are crossed.
std::string coverage_picture(const CalibrationReport& report);

// PNG: the residuals of camera and projector, above as points in pixels, below as magnified arrows in place.
std::string residual_picture(const CalibrationReport& report);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CALIBRATION_PICTURES_H
