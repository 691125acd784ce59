// Calibrations as files: OpenCV's YAML.
#ifndef SELFPROJ_RIG_CALIBRATION_FILE_H
#define SELFPROJ_RIG_CALIBRATION_FILE_H

#include <string>

#include "selfproj/rig/calibration.h"

namespace selfproj::rig {

// Reads cam_K, cam_kc, pro_K, pro_kc, R, T and, if present, cam_size and pro_size (width, height) from a file of
// cv::FileStorage (YAML, XML or JSON). Throws UserError with file, key and reason if the file is unreadable, a key is
// missing, a matrix has another size or is not a camera matrix (it has skew, the camera's focal length or the
// projector's fx is not > 0, or the projector's fy is 0), the distortion coefficients are not 4, 5 or 8, R is not a
// rotation, or T has length 0.
Calibration read_calibration(const std::string& file);

// Root mean squares of the residuals of a calibration, pixels; NaN is allowed.
struct CalibrationRms {
  double camera = 0, projector = 0, stereo = 0;
};

// The text of such a file: the keys above, T_C, T_P and T_P_rows of (4.7) without distortion (depth_matrices), and
// `rms` as cam_rms, pro_rms, stereo_rms. Distortion coefficients k4, k5, k6 are written only if one of them is not 0.
std::string calibration_yaml(const Calibration& calibration, const CalibrationRms& rms);

// Throws UserError, naming `source` and the line, for a text (YAML, JSON or XML) that cv::FileStorage would read
// wrongly or that would crash it: it is nested deeper than any calibration, has more than one document or aliases, or
// has a whole number that begins with 0, which OpenCV takes for an octal one ("010" for 8) or a hexadecimal one.
void check_calibration_text(const std::string& text, const std::string& source);

}  // namespace selfproj::rig

#endif  // SELFPROJ_RIG_CALIBRATION_FILE_H
