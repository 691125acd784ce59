// Calibration of camera and projector, from OpenCV's YAML.
#ifndef SELFPROJ_HOST_GRAY_CALIBRATION_FILE_H
#define SELFPROJ_HOST_GRAY_CALIBRATION_FILE_H

#include <opencv2/core/matx.hpp>
#include <string>

#include "host/gray/lens.h"

namespace selfproj {

// In the camera's frame, in mm: x_projector = R x_camera + T. A projector that shows its image mirrored has a negative
// fy: the camera sees its rows grow upwards where its columns grow to the right.
struct Calibration {
  Lens camera;
  Lens projector;
  cv::Matx33d rotation = cv::Matx33d::eye();      // R
  cv::Vec3d translation;                          // T
  int camera_columns = 0, camera_rows = 0;        // 0: not in the file
  int projector_columns = 0, projector_rows = 0;  // likewise
};

// Reads cam_K, cam_kc, pro_K, pro_kc, R, T and, where they are there, cam_size and pro_size (width, height) from a file
// of cv::FileStorage (YAML, XML or JSON). Throws UserError, naming file, key and reason: unreadable, a key missing, a
// matrix of another size, no camera matrix (skew, camera's focal length not > 0, projector's fx not > 0 or fy 0), other
// than 4, 5 or 8 distortion coefficients, R that is no rotation, T of length 0.
Calibration read_calibration(const std::string& file);

// The text of such a file: the keys above and, beside them, T_C, T_P and T_P_rows of (4.7) without distortion
// (rig_calibration.h), and `rms` (pixels) as camera_rms, projector_rms, stereo_rms.
struct CalibrationRms {
  double camera = 0, projector = 0, stereo = 0;
};
std::string calibration_yaml(const Calibration& calibration, const CalibrationRms& rms);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_GRAY_CALIBRATION_FILE_H
