// The residuals of chessboards on plates, as Ceres takes them, and what the covariance says of the belt. For bundle.cpp
// and its tests.
#ifndef SELFPROJ_HOST_CALIBRATION_PLATE_COST_H
#define SELFPROJ_HOST_CALIBRATION_PLATE_COST_H

#include <ceres/cost_function.h>

#include <Eigen/Core>

#include "host/calibration/bundle_plates.h"
#include "host/calibration/bundle_types.h"

namespace selfproj {

// The residuals of a view on a plate, six, in standard deviations of a tight tie: its pose less that of belt and plate.
// The blocks are belt pose, way and scale (3), plate_off, view.
ceres::CostFunction* plate_cost(const PlatePlace& place, const Plates& plates);

// Sets what the covariance says of the belt. Its unknowns are the last ones: the belt's pose, its way if it moves, the
// scale, and six of what each plate is off.
void fill_belt_deviations(const Eigen::MatrixXd& covariance, const Plates& plates, BundleResult& result);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_PLATE_COST_H
