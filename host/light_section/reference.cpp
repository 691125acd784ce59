#include "host/light_section/reference.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

#include "host/light_section/lens_reference.h"
#include "host/light_section/section_joins.h"
#include "host/rig/geometry.h"

namespace selfproj {
namespace {

void expect_columns(const Rig& rig, std::size_t given) {
  if (given != static_cast<std::size_t>(rig.camera.columns)) {
    throw std::invalid_argument("reference: as many values are needed as the camera has columns");
  }
}

// Whether a pattern line with this centre lies completely in the projector's image.
bool in_image(const Rig& rig, double line) {
  const double half = 0.5 * rig.measure.line_width_px;
  return line - half >= -0.5 && line + half <= rig.projector.lines - 0.5;
}

// The change of z from one projector line to the next at Xc = 0, mm: the derivative of (3.4).
double z_per_line(const Rig& rig, double tan_theta) {
  const double cosine = std::cos(std::atan(tan_theta) - rig.projector.tilt_rad);
  const double step = std::abs(rig.projector.line_pitch_mm) * (1 + tan_theta * tan_theta) * cosine * cosine /
                      rig.projector.focal_length_mm;  // of tan θ
  return step * rig.projector.x_mm / (tan_theta * tan_theta);
}

// Whether the projector lights the point of the curve.
bool is_lit(const Rig& rig, const std::vector<SectionJoin>& joins, const SectionPoint& point) {
  if (point.z <= rig.projector.z_mm || projector_depth(rig.projector, point.z) <= 0) {
    return false;
  }
  const double column = projector_column_on_middle(rig.projector, point.y, point.z);
  return in_image(rig, line_on_middle(rig.projector, point.z)) && column >= -0.5 &&
         column <= rig.projector.columns - 0.5 && !hidden(joins, {0, rig.projector.z_mm}, point) &&
         z_per_line(rig, rig.projector.x_mm / (point.z - rig.projector.z_mm)) <= rig.measure.max_z_per_line_mm;
}

}  // namespace

ReferenceCurve curve_of_heights(const Rig& rig, std::span<const double> height_mm) {
  expect_columns(rig, height_mm.size());
  const MiddleRow middle(rig);
  ReferenceCurve curve;
  for (std::size_t i = 0; i < height_mm.size(); ++i) {
    const double z = rig.plane_z_mm - height_mm[i];
    curve.z_mm.push_back(z);
    curve.y_mm.push_back(z * middle.tan_beta(static_cast<double>(i)));
  }
  return curve;
}

ReferenceCurve curve_of_reference(const Rig& rig, const ReferenceProfile& reference) {
  expect_columns(rig, reference.valid.size());
  const MiddleRow middle(rig);
  const int columns = rig.camera.columns;
  const auto z_of = [&](int column) {
    const auto i = static_cast<std::size_t>(column);
    return reference.valid[i] != 0 ? reference.z_mm[i] : kUnknown;
  };
  // Continues from the column `border` with the slope of the last `kBeyond` columns, in the direction against `inward`;
  // NaN if one of these two columns is invalid.
  constexpr int kBeyond = 8;
  const auto beyond = [&](int border, int inward, int steps) {
    return columns <= kBeyond ? kUnknown
                              : z_of(border) + (z_of(border) - z_of(border + inward * kBeyond)) * steps / kBeyond;
  };
  ReferenceCurve curve;
  for (int i = -kBeyond; i < columns + kBeyond; ++i) {
    const double z = i < 0 ? beyond(0, 1, -i) : i >= columns ? beyond(columns - 1, -1, i - columns + 1) : z_of(i);
    curve.z_mm.push_back(z);
    curve.y_mm.push_back(z * middle.tan_beta(i));
  }
  return curve;
}

ReferenceProfile reference_of_curve(const Rig& rig, const ReferenceCurve& curve) {
  if (!rig.is_pinholes()) {
    return lens_reference_of_curve(rig, curve);
  }
  const std::vector<SectionJoin> joins = joins_of(curve);
  ReferenceProfile reference;
  reference.resize(rig.camera.columns);
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    const SectionSight seen = sight_along(joins, tan_beta(rig.camera, static_cast<double>(i)));
    const SectionPoint& nearest = seen.at;
    const bool valid = seen.join != nullptr && !seen.join->wall && is_lit(rig, joins, nearest);
    reference.valid[i] = valid ? 1 : 0;
    reference.z_mm[i] = valid ? nearest.z : kUnknown;
    reference.tan_theta[i] = valid ? rig.projector.x_mm / (nearest.z - rig.projector.z_mm) : kUnknown;  // (3.8)
    reference.offset_px[i] = valid ? 0 : kUnknown;
  }
  return reference;
}

ReferenceProfile reference_of_plane(const Rig& rig) {
  const std::vector<double> heights(static_cast<std::size_t>(rig.camera.columns), 0.0);
  return reference_of_curve(rig, curve_of_heights(rig, heights));
}

ReferenceProfile reference_of_straight_line(const Rig& rig, double line, std::span<const double> centroid) {
  expect_columns(rig, centroid.size());
  if (!rig.is_pinholes()) {
    return lens_reference_of_line(rig, line, centroid);
  }
  const double theta = tan_theta(rig.projector, line);
  ReferenceProfile reference;
  reference.resize(rig.camera.columns);
  for (std::size_t i = 0; i < centroid.size(); ++i) {
    const double sum = tan_alpha(rig.camera, centroid[i]) + theta;
    const bool valid = std::isfinite(centroid[i]) && sum > 0;
    reference.valid[i] = valid ? 1 : 0;
    reference.tan_theta[i] = theta;
    reference.z_mm[i] = valid ? (rig.projector.x_mm + rig.projector.z_mm * theta) / sum : kUnknown;  // (3.4)
    reference.offset_px[i] = valid ? centroid[i] - middle_row(rig.camera) : kUnknown;
  }
  return reference;
}

ReferenceProfile without_residual(const Rig& rig, const ReferenceProfile& reference, std::span<const double> centroid) {
  expect_columns(rig, centroid.size());
  expect_columns(rig, reference.valid.size());
  if (!rig.is_pinholes()) {
    return lens_without_residual(rig, reference, centroid);
  }
  ReferenceProfile result = reference;
  for (std::size_t i = 0; i < centroid.size(); ++i) {
    if (result.valid[i] == 0 || !std::isfinite(centroid[i])) {
      result.valid[i] = 0;
      result.tan_theta[i] = result.z_mm[i] = result.offset_px[i] = kUnknown;
      continue;
    }
    const double x = result.z_mm[i] * tan_alpha(rig.camera, centroid[i]);
    result.tan_theta[i] = (rig.projector.x_mm - x) / (result.z_mm[i] - rig.projector.z_mm);
    result.offset_px[i] = centroid[i] - middle_row(rig.camera);
  }
  return result;
}

std::vector<double> pattern_of_curve(const Rig& rig, const ReferenceCurve& curve) {
  if (!rig.is_pinholes()) {
    return lens_pattern_of_curve(rig, curve);
  }
  const RigProjector& projector = rig.projector;
  const std::vector<SectionJoin> joins = joins_of(curve);
  std::vector<double> lines(static_cast<std::size_t>(projector.columns), kUnknown);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double yp =
        projector.center_yp_mm + projector.column_pitch_mm * (static_cast<double>(i) - 0.5 * (projector.columns - 1));
    // The points of the plane x = 0 that the column lights: y fp = Yp ((z - z0) cos θ0 + x0 sin θ0).
    const double slope = yp * std::cos(projector.tilt_rad);
    const double level = yp * projector_depth(projector, 0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const SectionJoin& join : joins) {
      SectionPoint at{};
      if (!join.wall && crossing(join, projector.focal_length_mm, -slope, level, at) && at.z < nearest &&
          is_lit(rig, joins, at) && !hidden(joins, {0, 0}, at)) {
        nearest = at.z;
        lines[i] = line_on_middle(projector, at.z);
      }
    }
  }
  return lines;
}

}  // namespace selfproj
