#include "host/calibration/bundle_cost.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace selfproj::calibration::bundle_cost {
namespace {

using RowsOf3 = Eigen::Matrix<double, 2, 3>;
template <int Columns>
using Block = Eigen::Map<Eigen::Matrix<double, 2, Columns, Eigen::RowMajor>>;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

// A pose from its six numbers.
class Motion {
 public:
  explicit Motion(const double* pose) : translation_(pose[3], pose[4], pose[5]) {
    constexpr double kSmall = 1e-6;  // rad, below which the series serve
    const Eigen::Vector3d rotation(pose[0], pose[1], pose[2]);
    const double angle = rotation.norm();
    const double square = angle * angle;
    const bool small = angle < kSmall;
    const double first = small ? 1 : std::sin(angle) / angle;
    const double second = small ? 0.5 : (1 - std::cos(angle)) / square;
    const double third = small ? 1.0 / 6 : (1 - first) / square;
    const Eigen::Matrix3d cross = cross_matrix(rotation);
    turn_.noalias() = Eigen::Matrix3d::Identity() + first * cross + second * cross * cross;
    right_.noalias() = Eigen::Matrix3d::Identity() - second * cross + third * cross * cross;
  }

  [[nodiscard]] const Eigen::Matrix3d& turn() const { return turn_; }
  [[nodiscard]] Eigen::Vector3d move(const Eigen::Vector3d& from) const { return turn_ * from + translation_; }

  // The derivatives of what `by_moved` is the derivative of, for the six numbers; `from` is the point moved.
  [[nodiscard]] Eigen::Matrix<double, 2, kPose> derivatives(const RowsOf3& by_moved,
                                                            const Eigen::Vector3d& from) const {
    Eigen::Matrix<double, 2, kPose> result;
    result.leftCols<3>().noalias() = -(by_moved * turn_) * (cross_matrix(from) * right_);
    result.rightCols<3>() = by_moved;
    return result;
  }

 private:
  Eigen::Vector3d translation_;
  Eigen::Matrix3d turn_, right_;  // the rotation and its right Jacobian
};

// The pixel of a point through a lens.
class Projection {
 public:
  Projection(const double* lens, const Eigen::Vector3d& point)
      : lens_(lens), x_(point[0] / point[2]), y_(point[1] / point[2]), s_(x_ * x_ + y_ * y_), z_(point[2]) {
    q_ = 1 + s_ * (lens[4] + s_ * (lens[5] + s_ * lens[8]));
    u_ = x_ * q_ + 2 * lens[6] * x_ * y_ + lens[7] * (s_ + 2 * x_ * x_);
    v_ = y_ * q_ + lens[6] * (s_ + 2 * y_ * y_) + 2 * lens[7] * x_ * y_;
  }

  [[nodiscard]] Eigen::Vector2d pixel() const { return {lens_[0] * u_ + lens_[2], lens_[1] * v_ + lens_[3]}; }

  [[nodiscard]] Eigen::Matrix<double, 2, kLens> by_lens() const {
    const double xy = 2 * x_ * y_;
    Eigen::Matrix<double, 2, kLens> result;
    result << u_, 0, 1, 0, x_ * s_, x_ * s_ * s_, xy, s_ + 2 * x_ * x_, x_ * s_ * s_ * s_,  //
        0, v_, 0, 1, y_ * s_, y_ * s_ * s_, s_ + 2 * y_ * y_, xy, y_ * s_ * s_ * s_;
    result.row(0).tail<kLens - kPinholeParameters>() *= lens_[0];
    result.row(1).tail<kLens - kPinholeParameters>() *= lens_[1];
    return result;
  }

  [[nodiscard]] RowsOf3 by_point() const {
    const double slope = lens_[4] + s_ * (2 * lens_[5] + 3 * s_ * lens_[8]);
    const double mixed = 2 * (x_ * y_ * slope + lens_[6] * x_ + lens_[7] * y_);
    const double ux = lens_[0] * (q_ + 2 * x_ * x_ * slope + 2 * lens_[6] * y_ + 6 * lens_[7] * x_) / z_;
    const double uy = lens_[0] * mixed / z_;
    const double vx = lens_[1] * mixed / z_;
    const double vy = lens_[1] * (q_ + 2 * y_ * y_ * slope + 6 * lens_[6] * y_ + 2 * lens_[7] * x_) / z_;
    RowsOf3 result;
    result << ux, uy, -ux * x_ - uy * y_, vx, vy, -vx * x_ - vy * y_;
    return result;
  }

 private:
  const double* lens_;
  double x_, y_, s_, z_;
  double q_ = 0, u_ = 0, v_ = 0;
};

// The derivatives for the coefficients of the shape, from those for the corner's place on the chessboard.
void shape_derivatives(const RowsOf3& by_place, const CornerModes& modes, const BundleNoise& noise, double* to) {
  Block<kSharedModes> block(to);
  for (int i = 0; i < kBendModes; ++i) {
    block.col(i) = noise.bend * modes.bend[static_cast<std::size_t>(i)] * by_place.col(2);
  }
  for (int i = 0; i < kStretchModes; ++i) {
    const cv::Vec2d& mode = modes.stretch[static_cast<std::size_t>(i)];
    block.col(kBendModes + i) = noise.stretch * (mode[0] * by_place.col(0) + mode[1] * by_place.col(1));
  }
}

// Those for a view's pose and its own bend.
void view_derivatives(const Motion& motion, const RowsOf3& by_moved, const RowsOf3& by_place,
                      const Eigen::Vector3d& point, const CornerModes& modes, const BundleNoise& noise, double* to) {
  Block<kView> block(to);
  block.leftCols<kPose>() = motion.derivatives(by_moved, point);
  for (int i = 0; i < kOwnModes; ++i) {
    block.col(kPose + i) = noise.own * modes.bend[static_cast<std::size_t>(i)] * by_place.col(2);
  }
}

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

}  // namespace

const CornerModes& modes_at(const std::vector<CornerModes>* shape, const Sight& sight) {
  static const CornerModes flat;
  return shape == nullptr ? flat : (*shape)[static_cast<std::size_t>(sight.corner)];
}

Eigen::Vector3d place(const Sight& sight, const CornerModes& modes, const BundleNoise& noise, const double* shape,
                      const double* own) {
  Eigen::Vector3d point(sight.chessboard.x, sight.chessboard.y, 0);
  for (std::size_t i = 0; i < kBendModes; ++i) {
    point[2] += noise.bend * modes.bend[i] * shape[i];
  }
  for (std::size_t i = 0; i < kOwnModes; ++i) {
    point[2] += noise.own * modes.bend[i] * own[i];
  }
  for (std::size_t i = 0; i < kStretchModes; ++i) {
    point[0] += noise.stretch * modes.stretch[i][0] * shape[kBendModes + i];
    point[1] += noise.stretch * modes.stretch[i][1] * shape[kBendModes + i];
  }
  return point;
}

ViewCost::ViewCost(bool in_projector, const View& view, const std::vector<CornerModes>* shape, const BundleNoise& noise)
    : in_projector_(in_projector), view_(view), shape_(shape), noise_(noise) {
  set_num_residuals(2 * static_cast<int>(view.sights.size()));
  *mutable_parameter_block_sizes() =
      in_projector ? std::vector<int>{kLens, kPose, kView, kSharedModes} : std::vector<int>{kLens, kView, kSharedModes};
}

ViewCost::ViewCost(InCamera /*image*/, const View& view, const std::vector<CornerModes>* shape,
                   const BundleNoise& noise)
    : ViewCost(false, view, shape, noise) {}

ViewCost::ViewCost(InProjector /*image*/, const View& view, const std::vector<CornerModes>* shape,
                   const BundleNoise& noise)
    : ViewCost(true, view, shape, noise) {}

bool ViewCost::Evaluate(const double* const* parameters, double* residuals, double** jacobians) const {
  const std::size_t view_block = in_projector_ ? 2 : 1;
  constexpr double kStill[kPose] = {};  // NOLINT(modernize-avoid-c-arrays,cppcoreguidelines-avoid-c-arrays)
  const Motion to_camera(parameters[view_block]);
  const Motion to_projector(in_projector_ ? parameters[1] : kStill);
  const double noise = in_projector_ ? noise_.projector : noise_.camera;
  // Where the derivatives of corner i for a block of `columns` begin; nothing if they are not asked for.
  const auto to = [&](std::size_t block, std::size_t i, int columns) -> double* {
    const bool asked = jacobians != nullptr && jacobians[block] != nullptr;
    return asked ? jacobians[block] + 2 * i * static_cast<std::size_t>(columns) : nullptr;
  };
  for (std::size_t i = 0; i < view_.sights.size(); ++i) {
    const Sight& sight = view_.sights[i];
    const CornerModes& modes = modes_at(shape_, sight);
    const Eigen::Vector3d point =
        place(sight, modes, noise_, parameters[view_block + 1], parameters[view_block] + kPose);
    const Eigen::Vector3d in_camera = to_camera.move(point);
    const Projection projection(parameters[0], in_projector_ ? to_projector.move(in_camera) : in_camera);
    const cv::Point2d& at = in_projector_ ? sight.projector : sight.camera;
    Eigen::Map<Eigen::Vector2d>(residuals + 2 * i) = (Eigen::Vector2d(at.x, at.y) - projection.pixel()) / noise;
    if (jacobians == nullptr) {
      continue;
    }
    if (double* block = to(0, i, kLens)) {
      Block<kLens>{block} = -projection.by_lens() / noise;
    }
    RowsOf3 by_moved = -projection.by_point() / noise;
    if (in_projector_) {
      if (double* block = to(1, i, kPose)) {
        Block<kPose>{block} = to_projector.derivatives(by_moved, in_camera);
      }
      by_moved = (by_moved * to_projector.turn()).eval();
    }
    const RowsOf3 by_place = by_moved * to_camera.turn();
    if (double* block = to(view_block, i, kView)) {
      view_derivatives(to_camera, by_moved, by_place, point, modes, noise_, block);
    }
    if (double* block = to(view_block + 1, i, kSharedModes)) {
      shape_derivatives(by_place, modes, noise_, block);
    }
  }
  return true;
}

ceres::CostFunction* plate_cost(const PlatePlace& place, const Plates& plates) {
  return new ceres::AutoDiffCostFunction<PlateResidual, kPose, kPose, 3, kPose, kView>(
      new PlateResidual(place, plates));
}

}  // namespace selfproj::calibration::bundle_cost
