#include "host/calibration/bundle_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace selfproj::calibration {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Successive rows that have their entries in the same columns, as a dense matrix of these columns.
struct DenseRows {
  Eigen::Index first;
  std::vector<Eigen::Index> columns;
  Eigen::Map<const RowMajor> values;
};

// Calls function(DenseRows) for all rows in turn. Those of one residual block of Ceres come together.
template <typename Function>
void for_each_block(const ceres::CRSMatrix& j, const Function& function) {
  const auto begin = [&](int row) { return j.cols.begin() + j.rows[static_cast<std::size_t>(row)]; };
  for (int first = 0, next = 0; first < j.num_rows; first = next) {
    while (next < j.num_rows && std::equal(begin(first), begin(first + 1), begin(next), begin(next + 1))) {
      ++next;
    }
    const std::vector<Eigen::Index> columns(begin(first), begin(first + 1));
    const double* values = j.values.data() + j.rows[static_cast<std::size_t>(first)];
    function(DenseRows{first, columns, {values, next - first, static_cast<Eigen::Index>(columns.size())}});
  }
}

}  // namespace

Eigen::MatrixXd normal_matrix(const ceres::CRSMatrix& jacobian) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(jacobian.num_cols, jacobian.num_cols);
  for_each_block(jacobian, [&](const DenseRows& rows) {
    normal(rows.columns, rows.columns) += rows.values.transpose() * rows.values;
  });
  return normal;
}

Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& normal) {
  constexpr double kNothing = 1e-13;  // eigenvalue of the scaled matrix that counts as 0, relative to the greatest
  const Eigen::VectorXd scale = normal.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
  const Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factors(scaled);
  if (factors.info() == Eigen::Success && factors.rcond() > kNothing) {
    const Eigen::MatrixXd inverted = factors.solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols()));
    return scale.asDiagonal() * inverted * scale.asDiagonal();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  const double least = kNothing * solver.eigenvalues().maxCoeff();
  const Eigen::VectorXd inverted = solver.eigenvalues().cwiseMax(least).cwiseInverse();
  const Eigen::MatrixXd half = scale.asDiagonal() * solver.eigenvectors();
  return half * inverted.asDiagonal() * half.transpose();
}

std::vector<double> leverages(const ceres::CRSMatrix& jacobian, const Eigen::MatrixXd& covariance) {
  std::vector<double> result(static_cast<std::size_t>(jacobian.num_rows));
  for_each_block(jacobian, [&](const DenseRows& rows) {
    const Eigen::MatrixXd part = covariance(rows.columns, rows.columns);
    const RowMajor product = rows.values * part;
    Eigen::Map<Eigen::VectorXd>(result.data() + rows.first, rows.values.rows()) =
        product.cwiseProduct(rows.values).rowwise().sum();
  });
  return result;
}

namespace {

// Reads standard deviations from a covariance, one unknown after the other.
class DeviationReader {
 public:
  DeviationReader(const Eigen::MatrixXd& covariance, double factor) : covariance_(covariance), factor_(factor) {}

  double next() {
    const double variance = covariance_(at_, at_);
    ++at_;
    return factor_ * std::sqrt(std::max(0.0, variance));
  }
  void skip(int count) { at_ += count; }
  [[nodiscard]] int at() const { return at_; }

  Pose pose() {
    Pose pose;
    for (int i = 0; i < 3; ++i) {
      pose.rotation[i] = next();
    }
    for (int i = 0; i < 3; ++i) {
      pose.translation[i] = next();
    }
    return pose;
  }

  // A lens of `free` coefficients, of which the first `estimated` are of interest.
  void lens(LensParameters& lens, int free, int estimated) {
    for (int i = 0; i < kPinholeParameters + estimated; ++i) {
      lens[static_cast<std::size_t>(i)] = next();
    }
    skip(free - estimated);
  }

 private:
  const Eigen::MatrixXd& covariance_;
  double factor_;
  int at_ = 0;
};

}  // namespace

double widening_of(std::size_t views) {
  const double freedom = static_cast<double>(views) - 1;  // Cornish and Fisher's expansion at one standard deviation
  return 1 + 0.5 / freedom + 0.25 / (freedom * freedom);
}

void add_distortion_prior(Eigen::MatrixXd& normal, const BundleLayout& layout, const FreeDistortion& estimated) {
  constexpr std::array<double, 5> kUsual{0.2, 0.3, 0.001, 0.001, 0.3};  // k1, k2, p1, p2, k3
  const auto add = [&](int lens, int first, int last) {
    for (int i = first; i < last; ++i) {
      const int at = lens + kPinholeParameters + i;
      normal(at, at) += 1 / std::pow(kUsual.at(static_cast<std::size_t>(i)), 2);
    }
  };
  add(0, estimated.camera, layout.free.camera);
  if (layout.projector) {
    add(layout.camera_lens(), estimated.projector, layout.free.projector);
  }
}

cv::Mat1d distortion_covariance(const Eigen::MatrixXd& covariance, const BundleLayout& layout) {
  std::vector<int> places;
  for (int i = 0; i < layout.free.camera; ++i) {
    places.push_back(kPinholeParameters + i);
  }
  for (int i = 0; layout.projector && i < layout.free.projector; ++i) {
    places.push_back(layout.camera_lens() + kPinholeParameters + i);
  }
  const int count = static_cast<int>(places.size());
  cv::Mat1d result(count, count);
  for (int a = 0; a < count; ++a) {
    for (int b = 0; b < count; ++b) {
      result(a, b) = covariance(places[static_cast<std::size_t>(a)], places[static_cast<std::size_t>(b)]);
    }
  }
  return result;
}

void fill_deviations(const Eigen::MatrixXd& covariance, const BundleLayout& layout, const FreeDistortion& estimated,
                     BundleResult& result) {
  const double widening = layout.views > 1 ? widening_of(layout.views) : 1;
  DeviationReader read(covariance, widening);
  Bundle& deviation = result.deviation;
  read.lens(deviation.camera, layout.free.camera, estimated.camera);
  if (layout.projector) {
    read.lens(deviation.projector, layout.free.projector, estimated.projector);
    const int translation = read.at() + 3;
    deviation.stereo = read.pose();
    const cv::Vec3d t = cv::normalize(result.bundle.stereo.translation);
    const Eigen::Vector3d along(t[0], t[1], t[2]);
    const Eigen::Matrix3d block = covariance.block<3, 3>(translation, translation);
    result.baseline_deviation = widening * std::sqrt(std::max(0.0, along.dot(block * along)));
  }
  read.skip(layout.shaped ? kSharedModes : 0);
  for (std::size_t v = 0; v < layout.views; ++v) {
    deviation.chessboard.push_back(read.pose());
    read.skip(layout.shaped ? kOwnModes : 0);
  }
}

namespace {

cv::Matx33d turn_of_belt(const cv::Vec3d& rotation) {
  cv::Matx33d matrix;
  cv::Rodrigues(rotation, matrix);
  return matrix;
}

}  // namespace

void fill_belt_deviations(const Eigen::MatrixXd& covariance, const Plates& plates, BundleResult& result) {
  const Bundle& found = result.bundle;
  const int way = plates.moved ? 2 : 0;
  const int plate_unknowns = kPoseParameters * static_cast<int>(found.belt.plate_off.size());
  const int scale = static_cast<int>(covariance.rows()) - plate_unknowns - 1;
  const int belt = scale - way - kPoseParameters;
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

}  // namespace selfproj::calibration
