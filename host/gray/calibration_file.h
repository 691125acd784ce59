// Calibration of camera and projector, from OpenCV's YAML.
#ifndef SELFPROJ_HOST_GRAY_CALIBRATION_FILE_H
#define SELFPROJ_HOST_GRAY_CALIBRATION_FILE_H

#include <opencv2/core/matx.hpp>
#include <string>

#include "host/gray/lens.h"

namespace selfproj {

// In the camera's frame, in mm: x_projector = R x_camera + T.
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
// matrix of another size, no camera matrix (skew, focal length not > 0), other than 4, 5 or 8 distortion coefficients,
// R that is no rotation, T of length 0.
Calibration read_calibration(const std::string& file);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_GRAY_CALIBRATION_FILE_H
