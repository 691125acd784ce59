// Least squares over all unknowns of a bundle together, by Ceres.
#ifndef SELFPROJ_HOST_CALIBRATION_BUNDLE_SOLVER_H
#define SELFPROJ_HOST_CALIBRATION_BUNDLE_SOLVER_H

#include <opencv2/core/matx.hpp>
#include <vector>

#include "host/calibration/bundle.h"

namespace selfproj::calibration {

// Ceres' Levenberg-Marquardt from a start, with the chessboard's poses eliminated (Schur). By default it
// estimates the noise too, as variance components: the weighted sum of squares of each kind of residual comes to what
// the number of these residuals leaves after the unknowns. Throws std::invalid_argument if there are fewer equations
// than unknowns, and std::runtime_error if it does not converge.
BundleResult solve_bundle(const std::vector<View>& views, const Bundle& start, const BundleOptions& options);

// The pose of one view by camera and projector together, with everything else as in `bundle`; `start` is the start.
// Its residuals are those of a chessboard with the shared shape. Throws std::runtime_error if it does not converge.
BundleResult locate_view(const View& view, const Bundle& bundle, const Pose& start,
                         const std::vector<CornerModes>* shape);

// Where a corner is on the chessboard, mm: the drawing, with the shared shape if `shape` is given.
cv::Vec3d place_on_board(const Sight& sight, const Bundle& bundle, const std::vector<CornerModes>* shape);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_BUNDLE_SOLVER_H
