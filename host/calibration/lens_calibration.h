// Zhang's method: one lens, and the poses of a chessboard in front of it, from the places of its corners in images.
#ifndef SELFPROJ_HOST_CALIBRATION_LENS_CALIBRATION_H
#define SELFPROJ_HOST_CALIBRATION_LENS_CALIBRATION_H

#include <opencv2/core/types.hpp>
#include <vector>

#include "host/calibration/bundle.h"

namespace selfproj {

struct LensCalibration {
  LensParameters lens{};
  std::vector<Pose> chessboard;  // lens from chessboard, one for each view
  double rms = 0;                // pixels
};

// `place` selects the pixels of a sight, &Sight::camera or &Sight::projector, of images of `size`. The first `free` of
// k1, k2, p1, p2, k3 are estimated (0, 1, 2, 4 or 5), the others are 0. Throws UserError if the poses do not determine
// a lens.
LensCalibration calibrate_lens(const std::vector<View>& views, cv::Size size, int free, cv::Point2d Sight::*place);

// Projector from camera. Each view gives one pose; the one nearest to all others is taken.
Pose stereo_pose(const LensCalibration& camera, const LensCalibration& projector);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_LENS_CALIBRATION_H
