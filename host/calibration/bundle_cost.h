// The residuals of the bundle and their derivatives, as Ceres takes them. For bundle_solver.cpp and its tests.
#ifndef SELFPROJ_HOST_CALIBRATION_BUNDLE_COST_H
#define SELFPROJ_HOST_CALIBRATION_BUNDLE_COST_H

#include <ceres/cost_function.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/plates.h"

namespace selfproj::calibration::bundle_cost {

inline constexpr int kLens = static_cast<int>(kLensParameters);
inline constexpr int kPose = kPoseParameters;
inline constexpr int kView = kPose + kOwnModes;  // the pose, and the bend of this view

// The modes of the chessboard's shape at a corner, all 0 if there is no shape.
const CornerModes& modes_at(const std::vector<CornerModes>* shape, const Sight& sight);

// The place of a corner on a chessboard with the coefficients `shape` and, of this view alone, `own`.
Eigen::Vector3d place(const Sight& sight, const CornerModes& modes, const BundleNoise& noise, const double* shape,
                      const double* own);

// The corners of one view in one of both images: seen less computed, in standard deviations, two residuals a corner.
// What it points to must outlive it.
class ViewCost final : public ceres::CostFunction {
 public:
  // The image of the camera; the blocks are lens, view, shape.
  struct InCamera {};
  // That of the projector; the blocks are lens, stereo, view, shape.
  struct InProjector {};

  ViewCost(InCamera image, const View& view, const std::vector<CornerModes>* shape, const BundleNoise& noise);
  ViewCost(InProjector image, const View& view, const std::vector<CornerModes>* shape, const BundleNoise& noise);

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

 private:
  ViewCost(bool in_projector, const View& view, const std::vector<CornerModes>* shape, const BundleNoise& noise);

  bool in_projector_;
  const View& view_;
  const std::vector<CornerModes>* shape_;
  const BundleNoise& noise_;
};

// The prior of coefficients: their own values, in standard deviations. The last Size of a block of Block.
template <int Size, int Block>
class PriorCost final : public ceres::SizedCostFunction<Size, Block> {
 public:
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    std::copy_n(parameters[0] + Block - Size, Size, residuals);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, Size, Block, Block == 1 ? Eigen::ColMajor : Eigen::RowMajor>> j(jacobians[0]);
      j.setZero();
      j.template rightCols<Size>().setIdentity();
    }
    return true;
  }
};

// The residuals of a view on a plate, six, in standard deviations of a tight tie: its pose less that of belt and plate.
// The blocks are belt pose, way and scale (3), plate_off, view.
ceres::CostFunction* plate_cost(const PlatePlace& place, const Plates& plates);

}  // namespace selfproj::calibration::bundle_cost

#endif  // SELFPROJ_HOST_CALIBRATION_BUNDLE_COST_H
