#include "selfproj/light_section/column_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host/rig/geometry.h"
#include "model/cpu_clones.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/rig/optics.h"

namespace selfproj::light_section {
namespace {

constexpr int kMaxDegree = ColumnCurves::kDegrees.back();
constexpr int kNodes = 2 * kMaxDegree + 5;   // where the curves are fitted
constexpr int kChecks = 4 * kMaxDegree + 5;  // where they are compared

}  // namespace

// The exact points of a column.
class ColumnCurves::ExactColumn {
 public:
  ExactColumn(const rig::RigOptics& optics, int column, const rig::LightSheet& sheet)
      : optics_(&optics), column_(column), sheet_(sheet) {}

  // The point that the centroid C (a row from 1) means.
  [[nodiscard]] std::optional<cv::Vec3d> at(double centroid) const {
    const rig::CameraPlace place{centroid - 1, static_cast<double>(column_)};
    const std::optional<cv::Vec2d> ray = optics_->ray(place);
    const std::optional<double> met = ray ? optics_->meet(*ray, sheet_) : std::nullopt;
    if (!met || !(optics_->z_per_line(*ray, *met) <= optics_->rig().measure.max_z_per_line_mm)) {
      return std::nullopt;
    }
    const double z = optics_->corrected(place, *met);
    return z > 0 && in_range(place, z) ? std::optional(cv::Vec3d((*ray)[0] * z, (*ray)[1] * z, z)) : std::nullopt;
  }

  [[nodiscard]] double rows() const { return optics_->rig().camera.rows; }

  // The centroids about `from` for which there is a point.
  [[nodiscard]] std::optional<std::pair<double, double>> range(double from) const {
    if (!at(from)) {
      return std::nullopt;
    }
    return std::pair{reach(from, 0.5), reach(from, rows() + 0.5)};
  }

 private:
  // Whether a laser's light at z is within what can be measured. Where rays grow parallel to its plane, z goes to
  // infinity; there a row is worth more of it than the rig allows, and the plane of the belt is far.
  [[nodiscard]] bool in_range(const rig::CameraPlace& place, double z) const {
    constexpr double kFarthest = 0.5;  // from the belt, as a share of its distance
    constexpr double kStep = 0.01;     // rows
    const rig::Rig& rig = optics_->rig();
    if (optics_->has_projector()) {
      return true;
    }
    if (!(std::abs(z - rig.plane_z_mm) <= kFarthest * rig.plane_z_mm)) {
      return false;
    }
    const std::optional<cv::Vec2d> ray = optics_->ray({place.row + kStep, place.column});
    const std::optional<double> next = ray ? optics_->meet(*ray, sheet_) : std::nullopt;
    return next &&
           std::abs(*next - *optics_->meet(*optics_->ray(place), sheet_)) <= kStep * rig.measure.max_z_per_line_mm;
  }

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

  const rig::RigOptics* optics_;
  int column_;
  rig::LightSheet sheet_;
};

namespace {

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
  rig::LightSheet sheet;
  std::array<std::pair<double, cv::Vec3d>, kNodes> nodes;  // t and point
  std::array<std::pair<double, cv::Vec3d>, kChecks> checks;
};

ColumnCurves::ColumnCurves(const rig::Rig& rig, const ReferenceProfile& reference) {
  if (reference.columns() != rig.camera.columns) {
    throw std::invalid_argument("profile: the reference has other columns than the camera");
  }
  const rig::RigOptics optics(rig);
  // A laser's light is where it is, with a reference or without.
  const bool whole = reference.valid_columns() == reference.columns();
  const std::optional<ReferenceProfile> plane =
      optics.has_projector() || whole ? std::nullopt : std::optional(reference_of_plane(rig));
  std::vector<Column> columns(reference.valid.size());
  for (int c = 0; c < reference.columns(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    Column& column = columns[i];
    const ReferenceProfile& from = reference.valid[i] != 0 || !plane ? reference : *plane;
    const std::optional<rig::LightSheet> sheet = sheet_of(optics, from, c);
    column.row_r = sheet ? rig::middle_row(rig.camera) + from.offset_px[i] : 0;
    column.sheet = sheet.value_or(rig::LightSheet{});
    const ExactColumn exact(optics, c, column.sheet);
    const std::pair<double, double> none;
    const auto [begin, end] = sheet ? exact.range(column.row_r).value_or(none) : none;
    valid.push_back(end > begin ? 1 : 0);
    first.push_back(static_cast<float>(valid[i] != 0 ? begin : 0));
    last.push_back(static_cast<float>(valid[i] != 0 ? end : 0));
    if (valid[i] != 0) {
      const cv::Vec2d ray = *optics.ray({column.row_r - 1, static_cast<double>(c)});
      column.z_r = from.z_mm[i];
      column.a_r = ray[0];
      column.b_r = ray[1];
      sample(exact, begin, end, column);
    }
    row_r.push_back(static_cast<float>(column.row_r));
    z_r.push_back(reference.valid[i] != 0 ? static_cast<float>(column.z_r) : images::kNoValue);
    inverse.push_back(static_cast<float>(1 / column.z_r));
    a_r.push_back(static_cast<float>(column.a_r));
    b_r.push_back(static_cast<float>(column.b_r));
  }
  for (const int degree : kDegrees) {
    fit(columns, degree);
    if (fit_error_ <= kMaxError) {
      return;
    }
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (valid[i] != 0) {
      narrow(ExactColumn(optics, static_cast<int>(i), columns[i].sheet), i, columns[i]);
    }
  }
  fit(columns, degree_);
}

// The points of the column from one centroid to another.
void ColumnCurves::sample(const ExactColumn& exact, double from, double to, Column& column) {
  const double rows = exact.rows();
  const auto point = [&](double from_0_to_1) {
    const double centroid = from + from_0_to_1 * (to - from);
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

// Brings both ends of a column's range nearer to its reference until the fit of the greatest degree is exact enough.
void ColumnCurves::narrow(const ExactColumn& exact, std::size_t i, Column& column) {
  constexpr double kShare = 0.85;
  constexpr float kMinRows = 1;
  const auto row = static_cast<float>(column.row_r);
  while (fit(i, column, degree_) > kMaxError) {
    first[i] = row + static_cast<float>(kShare) * (first[i] - row);
    last[i] = row + static_cast<float>(kShare) * (last[i] - row);
    if (!(last[i] - first[i] >= kMinRows)) {
      valid[i] = 0;
      return;
    }
    sample(exact, static_cast<double>(first[i]), static_cast<double>(last[i]), column);
  }
}

void ColumnCurves::fit(const std::vector<Column>& columns, int degree) {
  degree_ = degree;
  fit_error_ = 0;
  for (auto* to : {&w, &a, &b}) {
    to->assign(static_cast<std::size_t>(degree) * columns.size(), 0);
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (valid[i] != 0) {
      fit_error_ = std::max(fit_error_, fit(i, columns[i], degree));
    }
  }
}

// Least squares at the nodes. Returns the greatest error at the checks.
double ColumnCurves::fit(std::size_t i, const Column& column, int degree) {
  const std::size_t count = valid.size();
  const auto powers = static_cast<std::size_t>(degree);
  cv::Mat_<double> matrix(kNodes, degree);
  cv::Mat_<double> right(kNodes, 3);
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
  double greatest = 0;
  for (const auto& [t, point] : column.checks) {
    const double z = 1 / (1 / column.z_r + horner(by_curve[0], degree, t));
    const cv::Vec3d found(z * (column.a_r + horner(by_curve[1], degree, t)),
                          z * (column.b_r + horner(by_curve[2], degree, t)), z);
    for (int axis = 0; axis < 3; ++axis) {
      greatest = std::max(greatest, std::abs(found[axis] - point[axis]));
    }
  }
  return greatest;
}

// As in differential_profile.cpp: vectorized for each instruction set, with the same bits from all.

namespace {

// The curves from the strip's first column on. The coefficients of the powers lie `columns` apart.
struct CurveTables {
  const float* row_r;
  const float* first;
  const float* last;
  const float* z_r;
  const float* inverse;
  const float* a_r;
  const float* b_r;
  const std::int32_t* valid;
  const float* w;
  const float* a;
  const float* b;
  std::ptrdiff_t columns;
  float per_row;
};

// sum = c_1 t + c_2 t² + ... of each column.
template <int Degree>
[[gnu::always_inline]] inline void polynomial(const float* __restrict t, int count,
                                              const float* __restrict coefficients, std::ptrdiff_t columns,
                                              float* __restrict sum) {
  for (int i = 0; i < count; ++i) {
    float s = coefficients[(Degree - 1) * columns + i];
    for (int k = Degree - 2; k >= 0; --k) {
      s = s * t[i] + coefficients[k * columns + i];
    }
    sum[i] = s * t[i];
  }
}

// One lateral coordinate and its difference from the reference.
[[gnu::always_inline]] inline void beside(const float* __restrict z, const float* __restrict dz,
                                          const float* __restrict tangent, const float* __restrict change, int count,
                                          float* __restrict at, float* __restrict difference) {
  for (int i = 0; i < count; ++i) {
    at[i] = z[i] * (tangent[i] + change[i]);
    difference[i] = tangent[i] * dz[i] + z[i] * change[i];
  }
}

[[gnu::always_inline]] inline void depth(const float* __restrict w, const float* __restrict inverse,
                                         const float* __restrict z_r, int count, float* __restrict z,
                                         float* __restrict dz) {
  for (int i = 0; i < count; ++i) {
    const float at = 1.0F / (inverse[i] + w[i]);
    z[i] = at;
    dz[i] = -z_r[i] * (at * w[i]);
  }
}

// Centroid, validity, and t, which is NaN if the column is not valid and makes all that follows NaN.
[[gnu::always_inline]] inline void begin(const StripMoments& moments, int count, const CurveTables& tables,
                                         const LineRules& line_rules, std::int32_t* __restrict state,
                                         float* __restrict centroid, float* __restrict t) {
  const LineRules rules = line_rules;  // by value, so that no store can change them
  const float per_row = tables.per_row;
  const float* __restrict row_r = tables.row_r;
  const float* __restrict first = tables.first;
  const float* __restrict last = tables.last;
  const std::int32_t* __restrict valid = tables.valid;
  for (int i = 0; i < count; ++i) {
    const std::int32_t m0 = moments.m0[static_cast<std::size_t>(i)];
    const std::int32_t n = moments.n[static_cast<std::size_t>(i)];
    const float c = static_cast<float>(moments.m1[static_cast<std::size_t>(i)]) / static_cast<float>(m0);  // (3.2)
    const float row = c + rules.offset;
    std::int32_t found = row >= first[i] ? code(Validity::valid) : code(Validity::out_of_range);
    found = row <= last[i] ? found : code(Validity::out_of_range);
    const std::int32_t second = moments.second[static_cast<std::size_t>(i)];
    const std::int32_t s = validity_of(c, m0, n, second, valid[i], found, rules);
    state[i] = s;
    centroid[i] = s == code(Validity::valid) ? row : images::kNoValue;
    t[i] = s == code(Validity::valid) ? (row - row_r[i]) * per_row : images::kNoValue;
  }
}

// Takes `count` <= kStrip columns.
template <int Degree>
[[gnu::always_inline]] inline void triangulate(const StripMoments& moments, int count, const CurveTables& k,
                                               const LineRules& rules, const ProfileView& out) {
  alignas(64) std::array<std::int32_t, kStrip> state;
  alignas(64) std::array<float, kStrip> t;
  alignas(64) std::array<float, kStrip> sum;
  begin(moments, count, k, rules, state.data(), out.centroid, t.data());
  polynomial<Degree>(t.data(), count, k.w, k.columns, sum.data());
  depth(sum.data(), k.inverse, k.z_r, count, out.z, out.dz);
  polynomial<Degree>(t.data(), count, k.a, k.columns, sum.data());
  beside(out.z, out.dz, k.a_r, sum.data(), count, out.x, out.dx);
  polynomial<Degree>(t.data(), count, k.b, k.columns, sum.data());
  beside(out.z, out.dz, k.b_r, sum.data(), count, out.y, out.dy);
  std::uint8_t* __restrict validity = out.validity;
  for (int i = 0; i < count; ++i) {
    validity[i] = static_cast<std::uint8_t>(state[static_cast<std::size_t>(i)]);
  }
}

using CurveStrip = void (*)(const StripMoments&, int, const CurveTables&, const LineRules&, const ProfileView&);

SELFPROJ_CLONES void strip_3(const StripMoments& moments, int count, const CurveTables& tables, const LineRules& rules,
                             const ProfileView& out) {
  triangulate<ColumnCurves::kDegrees[0]>(moments, count, tables, rules, out);
}

SELFPROJ_CLONES void strip_5(const StripMoments& moments, int count, const CurveTables& tables, const LineRules& rules,
                             const ProfileView& out) {
  triangulate<ColumnCurves::kDegrees[1]>(moments, count, tables, rules, out);
}

SELFPROJ_CLONES void strip_8(const StripMoments& moments, int count, const CurveTables& tables, const LineRules& rules,
                             const ProfileView& out) {
  triangulate<ColumnCurves::kDegrees[2]>(moments, count, tables, rules, out);
}

SELFPROJ_CLONES void unpack_words(model::ColumnWord word, const std::uint8_t* payload, int first, int count,
                                  StripMoments& moments) {
  unpack_strip(word, payload, first, count, moments);
}

// Calls unpack(first, count, moments) and the kernel for each strip of the columns from `begin` up to `end`.
template <class Unpack>
void for_each_strip(const ColumnCurves& curves, const LineRules& rules, int begin, int end, const ProfileView& out,
                    const Unpack& unpack) {
  const CurveStrip strip = curves.degree() == ColumnCurves::kDegrees[0]   ? strip_3
                           : curves.degree() == ColumnCurves::kDegrees[1] ? strip_5
                                                                          : strip_8;
  StripMoments moments;
  for (int first = begin; first < end; first += kStrip) {
    const int count = std::min(kStrip, end - first);
    unpack(first, count, moments);
    strip(moments, count,
          {curves.row_r.data() + first, curves.first.data() + first, curves.last.data() + first,
           curves.z_r.data() + first, curves.inverse.data() + first, curves.a_r.data() + first,
           curves.b_r.data() + first, curves.valid.data() + first, curves.w.data() + first, curves.a.data() + first,
           curves.b.data() + first, curves.columns(), 1.0F / rules.rows},
          rules, from_column(out, first));
  }
}

}  // namespace

void profile_by_curves(const ColumnCurves& curves, const LineRules& rules, model::ColumnWord word,
                       const std::uint8_t* payload, int begin, int end, const ProfileView& out) {
  for_each_strip(curves, rules, begin, end, out, [&](int first, int count, StripMoments& moments) {
    unpack_words(word, payload, first - begin, count, moments);
  });
}

void profile_by_curves(const ColumnCurves& curves, const LineRules& rules, const model::RunsView& runs,
                       const ProfileView& out) {
  for_each_strip(curves, rules, 0, curves.columns(), out,
                 [&](int first, int count, StripMoments& strip) { copy_runs(runs, first, count, strip); });
}

}  // namespace selfproj::light_section
