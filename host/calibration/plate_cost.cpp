#include "host/calibration/plate_cost.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "host/calibration/bundle_cost.h"

namespace selfproj {
namespace {

using bundle_cost::kPose;
using bundle_cost::kView;

// What a belt's guides and an encoder leave, between two places of one plate.
constexpr double kTightTurn = 2e-5;   // rad
constexpr double kTightShift = 2e-3;  // mm

class PlateResidual {
 public:
  PlateResidual(const PlatePlace& place, const Plates& plates)
      : place_(place), deviations_(plates.deviations), scale_deviation_(plates.scale_deviation) {}

  template <typename T>
  bool operator()(const T* belt, const T* way, const T* plate_off, const T* view, T* residuals) const {
    const std::array<T, 3> back{-belt[0], -belt[1], -belt[2]};
    std::array<T, 4> from_camera;
    std::array<T, 4> of_view;
    std::array<T, 4> turn;
    ceres::AngleAxisToQuaternion(back.data(), from_camera.data());
    ceres::AngleAxisToQuaternion(view, of_view.data());
    ceres::QuaternionProduct(from_camera.data(), of_view.data(), turn.data());
    ceres::QuaternionToAngleAxis(turn.data(), residuals);
    const std::array<T, 3> between{view[3] - belt[3], view[4] - belt[4], view[5] - belt[5]};
    ceres::QuaternionRotatePoint(from_camera.data(), between.data(), residuals + 3);
    residuals[3] -= place_.belt_mm * way[0];
    residuals[4] -= place_.belt_mm * way[1];
    // z leads away from the camera; poses are in units of the drawn chessboard.
    residuals[5] += place_.height_mm / (1.0 + scale_deviation_ * way[2]);
    for (std::size_t i = 0; i < deviations_.size(); ++i) {
      residuals[i] = (residuals[i] - deviations_[i] * plate_off[i]) / (i < 3 ? kTightTurn : kTightShift);
    }
    return true;
  }

 private:
  PlatePlace place_;
  std::array<double, 6> deviations_;
  double scale_deviation_;
};

cv::Matx33d turn_of_belt(const cv::Vec3d& rotation) {
  cv::Matx33d matrix;
  cv::Rodrigues(rotation, matrix);
  return matrix;
}

}  // namespace

ceres::CostFunction* plate_cost(const PlatePlace& place, const Plates& plates) {
  return new ceres::AutoDiffCostFunction<PlateResidual, kPose, kPose, 3, kPose, kView>(
      new PlateResidual(place, plates));
}

void fill_belt_deviations(const Eigen::MatrixXd& covariance, const Plates& plates, BundleResult& result) {
  const Bundle& found = result.bundle;
  const int way = plates.moved ? 2 : 0;
  const int plate_unknowns = kPose * static_cast<int>(found.belt.plate_off.size());
  const int scale = static_cast<int>(covariance.rows()) - plate_unknowns - 1;
  const int belt = scale - way - kPose;
  result.scale_deviation = std::sqrt(std::max(0.0, covariance(scale, scale)));
  // How x / z and y / z of the normal, less those of the ray of the image's middle, change with cx, cy and the turn.
  Eigen::Matrix<double, 2, 5> change = Eigen::Matrix<double, 2, 5>::Zero();
  change(0, 0) = 1 / found.camera[0];
  change(1, 1) = 1 / found.camera[1];
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    cv::Vec3d more = found.belt.pose.rotation;
    cv::Vec3d less = more;
    more[i] += kStep;
    less[i] -= kStep;
    const cv::Matx33d a = turn_of_belt(more);
    const cv::Matx33d b = turn_of_belt(less);
    change(0, 2 + i) = (a(0, 2) / a(2, 2) - b(0, 2) / b(2, 2)) / (2 * kStep);
    change(1, 2 + i) = (a(1, 2) / a(2, 2) - b(1, 2) / b(2, 2)) / (2 * kStep);
  }
  const std::array<int, 5> which{2, 3, belt, belt + 1, belt + 2};
  const Eigen::Matrix<double, 5, 5> block = covariance(which, which);
  result.lean_deviation = std::sqrt(std::max(0.0, (change * block * change.transpose()).trace()));
}

}  // namespace selfproj
