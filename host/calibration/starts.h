// Where the least squares of a calibration start.
#ifndef SELFPROJ_HOST_CALIBRATION_STARTS_H
#define SELFPROJ_HOST_CALIBRATION_STARTS_H

#include <opencv2/core/types.hpp>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/plates.h"

namespace selfproj::calibration {

// Several starts, the likeliest first: lenses without distortion that differ in focal length and principal point, and
// the poses that follow from them; the last has every chessboard leaning the other way, which looks the same where
// perspective is weak. A flat chessboard is taken for granted. `camera` and `projector` are the sizes of the images.
// Starts that put a chessboard behind a lens are left out, so that there may be none.
std::vector<Bundle> bundle_starts(const std::vector<View>& views, cv::Size camera, cv::Size projector);

// The same for chessboards on plates, around the lenses of the drawings and with the pose between them. A chessboard on
// a plate begins square to the camera's axis.
std::vector<Bundle> bundle_starts_of(const std::vector<View>& views, const Plates& plates, cv::Size camera,
                                     cv::Size projector);

// The same for a camera alone.
std::vector<Bundle> camera_starts(const std::vector<View>& views, cv::Size camera);

// The pose of one view in front of a camera; the translation has z <= 0 if there is none.
Pose chessboard_pose(const View& view, const LensParameters& camera);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_STARTS_H
