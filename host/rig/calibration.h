// Calibration of camera and projector: the full model, lenses included.
#ifndef SELFPROJ_HOST_RIG_CALIBRATION_H
#define SELFPROJ_HOST_RIG_CALIBRATION_H

#include <opencv2/core/matx.hpp>

#include "host/rig/lens.h"

namespace selfproj {

// In the camera's frame and in mm, x_projector = R x_camera + T. A projector that shows its image mirrored has a
// negative fy: the camera sees the projector's rows grow upwards if its columns grow to the right.
struct Calibration {
  Lens camera;
  Lens projector;
  cv::Matx33d rotation = cv::Matx33d::eye();      // R
  cv::Vec3d translation;                          // T
  int camera_columns = 0, camera_rows = 0;        // 0 if the file does not say
  int projector_columns = 0, projector_rows = 0;  // 0 if the file does not say
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_CALIBRATION_H
