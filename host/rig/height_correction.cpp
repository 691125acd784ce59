#include "selfproj/rig/height_correction.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace selfproj::rig {
namespace {

using Chebyshev = std::array<double, kMaxHeightOrder + 1>;

Chebyshev chebyshev(double x) {
  Chebyshev t{1, x};
  for (std::size_t i = 2; i < t.size(); ++i) {
    t[i] = 2 * x * t[i - 1] - t[i - 2];
  }
  return t;
}

}  // namespace

HeightCorrection::HeightCorrection(const RigCamera& camera, const RigHeights& heights)
    : heights_(heights),
      row_middle_(0.5 * (camera.rows - 1)),
      row_half_(0.5 * camera.rows),
      column_middle_(0.5 * (camera.columns - 1)),
      column_half_(0.5 * camera.columns),
      degrees_(height_terms(heights.order, heights.order_heights)) {}

void HeightCorrection::terms(double row, double column, double height_mm, std::vector<double>& values) const {
  const double middle = 0.5 * (heights_.min_mm + heights_.max_mm);
  const double half = 0.5 * (heights_.max_mm - heights_.min_mm);
  const Chebyshev c = chebyshev(std::clamp((column - column_middle_) / column_half_, -1.0, 1.0));
  const Chebyshev r = chebyshev(std::clamp((row - row_middle_) / row_half_, -1.0, 1.0));
  const Chebyshev h = chebyshev((height_mm - middle) / half);
  values.clear();
  for (const auto& [column_degree, row_degree, height_degree] : degrees_) {
    values.push_back(c.at(static_cast<std::size_t>(column_degree)) * r.at(static_cast<std::size_t>(row_degree)) *
                     h.at(static_cast<std::size_t>(height_degree)));
  }
}

double HeightCorrection::at(double row, double column, double height_mm) const {
  // Far beyond its ends a polynomial means nothing.
  const double beyond = 0.25 * (heights_.max_mm - heights_.min_mm);
  if (!(height_mm >= heights_.min_mm - beyond && height_mm <= heights_.max_mm + beyond)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  std::vector<double> values;
  terms(row, column, height_mm, values);
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += heights_.corrections_mm[i] * values[i];
  }
  return sum;
}

}  // namespace selfproj::rig
