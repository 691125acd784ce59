// What the Jacobian of the least squares says of their unknowns: the normal matrix and its inverse, and the standard
// deviations of a bundle's parameters.
#ifndef SELFPROJ_HOST_CALIBRATION_BUNDLE_COVARIANCE_H
#define SELFPROJ_HOST_CALIBRATION_BUNDLE_COVARIANCE_H

#include <ceres/crs_matrix.h>

#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/plates.h"

namespace selfproj::calibration {

// J^T J.
Eigen::MatrixXd normal_matrix(const ceres::CRSMatrix& jacobian);

// The inverse of a normal matrix, whose unknowns have units of pixels, radians and mm and are scaled by its diagonal.
// Directions in which it vanishes get a very large variance.
Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& normal);

// J C J^T of each row: the share of its residual's variance that the unknowns, with this covariance, take away.
std::vector<double> leverages(const ceres::CRSMatrix& jacobian, const Eigen::MatrixXd& covariance);

// The order of the unknowns in the normal matrix: the camera's lens; with `projector` the projector's lens and the
// stereo pose; with `shaped` the chessboard's shape; for each view its pose and, with `shaped`, its own bend.
struct BundleLayout {
  FreeDistortion free;
  bool projector, shaped;
  std::size_t views;

  [[nodiscard]] int camera_lens() const { return kPinholeParameters + free.camera; }
  [[nodiscard]] int projector_lens() const { return projector ? kPinholeParameters + free.projector : 0; }
};

// The factor between the standard deviation of a normal distribution and the half width of a Student's t distribution
// that holds the same share (68 %): how much less is known where effects that differ from pose to pose are estimated
// from few poses, >= 2.
double widening_of(std::size_t views);

// Adds what is known beforehand of the distortion coefficients beyond `estimated`: they are near 0, as in usual lenses,
// with a standard deviation of 0.2 for k1, 0.3 for k2 and k3, and 0.001 for p1 and p2.
void add_distortion_prior(Eigen::MatrixXd& normal, const BundleLayout& layout, const FreeDistortion& estimated);

// The covariance of the free distortion coefficients, camera before projector.
cv::Mat1d distortion_covariance(const Eigen::MatrixXd& covariance, const BundleLayout& layout);

// Sets the deviations of the result. Coefficients beyond `estimated` get none.
void fill_deviations(const Eigen::MatrixXd& covariance, const BundleLayout& layout, const FreeDistortion& estimated,
                     BundleResult& result);

// Sets what the covariance says of the belt. Its unknowns are the last ones: the belt's pose, its way if it moves, the
// scale, and six of what each plate is off.
void fill_belt_deviations(const Eigen::MatrixXd& covariance, const Plates& plates, BundleResult& result);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_BUNDLE_COVARIANCE_H
