// Zhang's method: one lens, and the poses of a chessboard before it, from where its corners are seen.
#ifndef SELFPROJ_HOST_CALIBRATION_LENS_CALIBRATION_H
#define SELFPROJ_HOST_CALIBRATION_LENS_CALIBRATION_H

#include <opencv2/core/types.hpp>
#include <vector>

#include "host/calibration/bundle.h"

namespace selfproj {

struct LensCalibration {
  LensParameters lens{};
  std::vector<Pose> chessboard;  // lens from chessboard, one a view
  double rms = 0;                // pixels
};

// `place` says whose pixels of a sight are taken: &Sight::camera or &Sight::projector, of images of `size`. `free` of
// k1, k2, p1, p2, k3 are estimated (0, 1, 2, 4 or 5), the others are 0. Throws UserError where the poses do not
// determine a lens.
LensCalibration calibrate_lens(const std::vector<View>& views, cv::Size size, int free, cv::Point2d Sight::*place);

// Projector from camera: each view gives one pose, and that which is nearest to all others is taken.
Pose stereo_pose(const LensCalibration& camera, const LensCalibration& projector);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_LENS_CALIBRATION_H
