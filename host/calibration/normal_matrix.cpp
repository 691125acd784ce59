#include "host/calibration/normal_matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace selfproj {
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

}  // namespace selfproj
