// Profiles of any rig: for each camera column the curve from the row of the light to the point there, as polynomials.
#ifndef SELFPROJ_LIGHT_SECTION_COLUMN_CURVES_H
#define SELFPROJ_LIGHT_SECTION_COLUMN_CURVES_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/strip_moments.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

// With t = (C - C_r) / rows, where C_r is the centroid of the reference in this column, each curve is
//
//     1/z = 1/z_r + w(t),   x/z = a_r + a(t),   y/z = b_r + b(t)
//
// where w, a and b are polynomials without a constant term. The inverse of z is the one that is nearly straight: for
// pinholes w and a are linear, and b is 0. The differences from the reference follow without cancellation:
//
//     Δz = -z_r z w,   Δx = a_r Δz + z a,   Δy = b_r Δz + z b
class ColumnCurves {
 public:
  // The degrees that the kernel is compiled for.
  static constexpr std::array<int, 3> kDegrees = {3, 5, 8};

  // What x, y and z of a fit may be off, mm.
  static constexpr double kMaxError = 0.001;

  // Fits the curves of all columns with the least degree that is exact enough. If even the greatest misses kMaxError,
  // the rows of those columns end nearer to the reference. With a laser, a column without a reference has the curve
  // about the plane of the belt, and its differences are NaN; points lie within half the belt's distance of the belt,
  // where a row is worth at most max_z_per_line_mm. Throws std::invalid_argument if the reference has another number of
  // columns than the rig.
  ColumnCurves(const rig::Rig& rig, const ReferenceProfile& reference);

  [[nodiscard]] int columns() const { return static_cast<int>(valid.size()); }
  [[nodiscard]] int degree() const { return degree_; }

  // The greatest distance in x, y or z between fits and geometry, between and at the ends of the fitted places, mm.
  [[nodiscard]] double fit_error_mm() const { return fit_error_; }

  // One entry for each column.
  std::vector<float> row_r;         // C_r
  std::vector<float> first, last;   // the centroids for which there is a point
  std::vector<float> z_r, inverse;  // z_r, NaN without a reference, and 1/z_r
  std::vector<float> a_r, b_r;
  std::vector<std::int32_t> valid;  // 0 or 1

  // The coefficients of t, t², ...: degree() times columns() each, those of one power side by side.
  std::vector<float> w, a, b;

 private:
  class ExactColumn;
  struct Column;
  static void sample(const ExactColumn& exact, double from, double to, Column& column);
  void narrow(const ExactColumn& exact, std::size_t i, Column& column);
  void fit(const std::vector<Column>& columns, int degree);
  [[nodiscard]] double fit(std::size_t i, const Column& column, int degree);

  int degree_ = 0;
  double fit_error_ = 0;
};

// What DifferentialProfiler::profile does, for the columns from `begin` up to, without, `end`; the payload begins with
// column `begin`.
void profile_by_curves(const ColumnCurves& curves, const LineRules& rules, model::ColumnWord word,
                       const std::uint8_t* payload, int begin, int end, const ProfileView& out);
// The same for all columns, from runs.
void profile_by_curves(const ColumnCurves& curves, const LineRules& rules, const model::RunsView& runs,
                       const ProfileView& out);

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_COLUMN_CURVES_H
