#include "host/light_section/column_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host/files/user_error.h"
#include "host/light_section/lens_reference.h"
#include "host/rig/geometry.h"
#include "host/rig/optics.h"

namespace selfproj {
namespace {

constexpr int kMostDegree = ColumnCurves::kDegrees.back();
constexpr int kNodes = 2 * kMostDegree + 5;   // where the curves are fitted
constexpr int kChecks = 4 * kMostDegree + 5;  // where they are compared

// The exact points of a column.
class ExactColumn {
 public:
  ExactColumn(const RigOptics& optics, int column, const LightSheet& sheet)
      : optics_(&optics), column_(column), sheet_(sheet) {}

  // The point that the centroid C (a row from 1) means.
  [[nodiscard]] std::optional<cv::Vec3d> at(double centroid) const {
    const CameraPlace place{centroid - 1, static_cast<double>(column_)};
    const std::optional<cv::Vec2d> ray = optics_->ray(place);
    const std::optional<double> met = ray ? optics_->meet(*ray, sheet_) : std::nullopt;
    if (!met || !(optics_->z_per_line(*ray, *met) <= optics_->rig().measure.max_z_per_line_mm)) {
      return std::nullopt;
    }
    const double z = optics_->corrected(place, *met);
    return z > 0 ? std::optional(cv::Vec3d((*ray)[0] * z, (*ray)[1] * z, z)) : std::nullopt;
  }

  // The centroids about `from` for which there is a point.
  [[nodiscard]] std::optional<std::pair<double, double>> range(double from) const {
    const double rows = optics_->rig().camera.rows;
    if (!at(from)) {
      return std::nullopt;
    }
    return std::pair{reach(from, 0.5), reach(from, rows + 0.5)};
  }

 private:
  // How far from `from` towards `to` the points go.
  [[nodiscard]] double reach(double from, double to) const {
    constexpr int kSteps = 16;
    constexpr int kHalvings = 20;
    double good = from;
    for (int i = 1; i <= kSteps; ++i) {
      double next = from + (to - from) * i / kSteps;
      if (at(next)) {
        good = next;
        continue;
      }
      for (int k = 0; k < kHalvings; ++k) {
        const double middle = 0.5 * (good + next);
        (at(middle) ? good : next) = middle;
      }
      break;
    }
    return good;
  }

  const RigOptics* optics_;
  int column_;
  LightSheet sheet_;
};

double horner(const double* coefficients, int degree, double t) {
  double sum = 0;
  for (int k = degree - 1; k >= 0; --k) {
    sum = (sum + coefficients[k]) * t;
  }
  return sum;
}

}  // namespace

// A column before it is fitted.
struct ColumnCurves::Column {
  double row_r = 0, z_r = 1, a_r = 0, b_r = 0;
  std::array<std::pair<double, cv::Vec3d>, kNodes> nodes;  // t and point
  std::array<std::pair<double, cv::Vec3d>, kChecks> checks;
};

ColumnCurves::ColumnCurves(const Rig& rig, const ReferenceProfile& reference) {
  if (reference.columns() != rig.camera.columns) {
    throw std::invalid_argument("profile: the reference has other columns than the camera");
  }
  const RigOptics optics(rig);
  const double rows = rig.camera.rows;
  std::vector<Column> columns(reference.valid.size());
  for (int c = 0; c < reference.columns(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    Column& column = columns[i];
    const std::optional<LightSheet> sheet = sheet_of(optics, reference, c);
    column.row_r = sheet ? middle_row(rig.camera) + reference.offset_px[i] : 0;
    const ExactColumn exact(optics, c, sheet.value_or(LightSheet{}));
    const auto range = sheet ? exact.range(column.row_r) : std::nullopt;
    valid.push_back(range && range->second > range->first ? 1 : 0);
    first.push_back(static_cast<float>(valid[i] != 0 ? range->first : 0));
    last.push_back(static_cast<float>(valid[i] != 0 ? range->second : 0));
    if (valid[i] != 0) {
      const cv::Vec2d ray = *optics.ray({column.row_r - 1, static_cast<double>(c)});
      column.z_r = reference.z_mm[i];
      column.a_r = ray[0];
      column.b_r = ray[1];
      const auto point = [&](double from_0_to_1) {
        const double centroid = range->first + from_0_to_1 * (range->second - range->first);
        // A hair inside the range there may be none: its end was found by halving.
        return std::pair{(centroid - column.row_r) / rows, exact.at(centroid).value_or(*exact.at(column.row_r))};
      };
      for (std::size_t k = 0; k < kNodes; ++k) {
        const double angle = std::numbers::pi * (static_cast<double>(k) + 0.5) / kNodes;
        column.nodes.at(k) = point(0.5 - 0.5 * std::cos(angle));
      }
      for (std::size_t k = 0; k < kChecks; ++k) {
        column.checks.at(k) = point(static_cast<double>(k) / (kChecks - 1));
      }
    }
    row_r.push_back(static_cast<float>(column.row_r));
    z_r.push_back(static_cast<float>(column.z_r));
    inverse.push_back(static_cast<float>(1 / column.z_r));
    a_r.push_back(static_cast<float>(column.a_r));
    b_r.push_back(static_cast<float>(column.b_r));
  }
  for (const int degree : kDegrees) {
    degree_ = degree;
    fit_error_ = fit(columns, degree);
    if (fit_error_ <= kMostError) {
      return;
    }
  }
  throw UserError(rig.name,
                  fmt::format("its curves from rows to points are {:.3g} mm off when fitted by polynomials of "
                              "degree {}; {} mm is allowed",
                              fit_error_, degree_, kMostError));
}

// Least squares at the nodes. Returns the greatest error at the checks.
double ColumnCurves::fit(const std::vector<Column>& columns, int degree) {
  const std::size_t count = columns.size();
  const auto powers = static_cast<std::size_t>(degree);
  for (auto* to : {&w, &a, &b}) {
    to->assign(powers * count, 0);
  }
  double greatest = 0;
  cv::Mat_<double> matrix(kNodes, degree);
  cv::Mat_<double> right(kNodes, 3);
  for (std::size_t i = 0; i < count; ++i) {
    const Column& column = columns[i];
    if (valid[i] == 0) {
      continue;
    }
    for (int k = 0; k < kNodes; ++k) {
      const auto& [t, point] = column.nodes.at(static_cast<std::size_t>(k));
      double power = 1;
      for (int p = 0; p < degree; ++p) {
        matrix(k, p) = power *= t;
      }
      right(k, 0) = 1 / point[2] - 1 / column.z_r;
      right(k, 1) = point[0] / point[2] - column.a_r;
      right(k, 2) = point[1] / point[2] - column.b_r;
    }
    cv::Mat_<double> solved;
    cv::solve(matrix, right, solved, cv::DECOMP_QR);
    cv::Mat_<double> by_curve;
    cv::transpose(solved, by_curve);
    for (std::size_t p = 0; p < powers; ++p) {
      const auto power = static_cast<int>(p);
      w[p * count + i] = static_cast<float>(by_curve(0, power));
      a[p * count + i] = static_cast<float>(by_curve(1, power));
      b[p * count + i] = static_cast<float>(by_curve(2, power));
    }
    for (const auto& [t, point] : column.checks) {
      const double z = 1 / (1 / column.z_r + horner(by_curve[0], degree, t));
      const cv::Vec3d found(z * (column.a_r + horner(by_curve[1], degree, t)),
                            z * (column.b_r + horner(by_curve[2], degree, t)), z);
      for (int axis = 0; axis < 3; ++axis) {
        greatest = std::max(greatest, std::abs(found[axis] - point[axis]));
      }
    }
  }
  return greatest;
}

}  // namespace selfproj
