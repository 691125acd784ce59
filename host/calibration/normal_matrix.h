// What the Jacobian of a least-squares problem says of its unknowns: the normal matrix and its inverse.
#ifndef SELFPROJ_HOST_CALIBRATION_NORMAL_MATRIX_H
#define SELFPROJ_HOST_CALIBRATION_NORMAL_MATRIX_H

#include <ceres/crs_matrix.h>

#include <Eigen/Core>
#include <vector>

namespace selfproj {

// J^T J.
Eigen::MatrixXd normal_matrix(const ceres::CRSMatrix& jacobian);

// The inverse of a normal matrix, whose unknowns have units of pixels, radians and mm and are scaled by its diagonal.
// Directions in which it vanishes get a very large variance.
Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& normal);

// J C J^T of each row: the share of its residual's variance that the unknowns, with this covariance, take away.
std::vector<double> leverages(const ceres::CRSMatrix& jacobian, const Eigen::MatrixXd& covariance);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_NORMAL_MATRIX_H
