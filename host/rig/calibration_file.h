// Calibrations as files: OpenCV's YAML.
#ifndef SELFPROJ_HOST_RIG_CALIBRATION_FILE_H
#define SELFPROJ_HOST_RIG_CALIBRATION_FILE_H

#include <string>

#include "host/rig/calibration.h"

namespace selfproj {

// Reads cam_K, cam_kc, pro_K, pro_kc, R, T and, where they are there, cam_size and pro_size (width, height) from a file
// of cv::FileStorage (YAML, XML or JSON). Throws UserError, naming file, key and reason: unreadable, a key missing, a
// matrix of another size, no camera matrix (skew, camera's focal length not > 0, projector's fx not > 0 or fy 0), other
// than 4, 5 or 8 distortion coefficients, R that is no rotation, T of length 0.
Calibration read_calibration(const std::string& file);

// The text of such a file: the keys above and, beside them, T_C, T_P and T_P_rows of (4.7) without distortion
// (depth_matrices.h), and `rms` (pixels) as camera_rms, projector_rms, stereo_rms.
struct CalibrationRms {
  double camera = 0, projector = 0, stereo = 0;
};
std::string calibration_yaml(const Calibration& calibration, const CalibrationRms& rms);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_CALIBRATION_FILE_H
