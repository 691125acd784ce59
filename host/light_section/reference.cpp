#include "host/light_section/reference.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

#include "host/rig/geometry.h"

namespace selfproj {
namespace {

// Millimetres. A wall that begins where a surface ends does not hide that end.
constexpr double kTouch = 1e-6;

void expect_columns(const Rig& rig, std::size_t given) {
  if (given != static_cast<std::size_t>(rig.camera.columns)) {
    throw std::invalid_argument("reference: as many values are needed as the camera has columns");
  }
}

struct Point {
  double y;
  double z;
};

// The straight piece between two neighbours of a curve.
struct Join {
  Point a;
  Point b;
  bool wall;
};

std::vector<Join> joins_of(const ReferenceCurve& curve) {
  std::vector<Join> joins;
  for (std::size_t i = 0; i + 1 < curve.y_mm.size(); ++i) {
    const Point a{curve.y_mm[i], curve.z_mm[i]};
    const Point b{curve.y_mm[i + 1], curve.z_mm[i + 1]};
    if (std::isfinite(a.y) && std::isfinite(a.z) && std::isfinite(b.y) && std::isfinite(b.z)) {
      joins.push_back({a, b, std::abs(b.z - a.z) > kSteepest * std::abs(b.y - a.y)});
    }
  }
  return joins;
}

// Where the join meets the straight line p y + q z = r, if it does.
bool crossing(const Join& join, double p, double q, double r, Point& at) {
  const double a = p * join.a.y + q * join.a.z - r;
  const double b = p * join.b.y + q * join.b.z - r;
  if ((a > 0 && b > 0) || (a < 0 && b < 0) || (a == 0 && b == 0)) {
    return false;
  }
  const double t = a / (a - b);
  at = {join.a.y + t * (join.b.y - join.a.y), join.a.z + t * (join.b.z - join.a.z)};
  return true;
}

// Whether a part of the curve lies between (0, viewpoint_z) and the point, seen along x.
bool hidden(const std::vector<Join>& joins, double viewpoint_z, const Point& point) {
  const double depth = point.z - viewpoint_z;
  for (const Join& join : joins) {
    Point at{};
    if (crossing(join, depth, -point.y, -point.y * viewpoint_z, at) && at.z > viewpoint_z && at.z < point.z - kTouch) {
      return true;
    }
  }
  return false;
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
bool is_lit(const Rig& rig, const std::vector<Join>& joins, const Point& point) {
  if (point.z <= rig.projector.z_mm || projector_depth(rig.projector, point.z) <= 0) {
    return false;
  }
  const double column = projector_column_on_middle(rig.projector, point.y, point.z);
  return in_image(rig, line_on_middle(rig.projector, point.z)) && column >= -0.5 &&
         column <= rig.projector.columns - 0.5 && !hidden(joins, rig.projector.z_mm, point) &&
         z_per_line(rig, rig.projector.x_mm / (point.z - rig.projector.z_mm)) <= rig.measure.max_z_per_line_mm;
}

}  // namespace

int ReferenceProfile::valid_columns() const {
  return static_cast<int>(std::count_if(valid.begin(), valid.end(), [](std::uint8_t v) { return v != 0; }));
}

ReferenceCurve curve_of_heights(const Rig& rig, std::span<const double> height_mm) {
  expect_columns(rig, height_mm.size());
  ReferenceCurve curve;
  for (std::size_t i = 0; i < height_mm.size(); ++i) {
    const double z = rig.plane_z_mm - height_mm[i];
    curve.z_mm.push_back(z);
    curve.y_mm.push_back(z * tan_beta(rig.camera, static_cast<double>(i)));
  }
  return curve;
}

ReferenceCurve curve_of_reference(const Rig& rig, const ReferenceProfile& reference) {
  expect_columns(rig, reference.valid.size());
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
    curve.y_mm.push_back(z * tan_beta(rig.camera, i));
  }
  return curve;
}

ReferenceProfile reference_of_curve(const Rig& rig, const ReferenceCurve& curve) {
  const std::vector<Join> joins = joins_of(curve);
  ReferenceProfile reference;
  reference.resize(rig.camera.columns);
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    const double tangent = tan_beta(rig.camera, static_cast<double>(i));
    const Join* seen = nullptr;  // the nearest one with y = z tan β; if a surface ends at a wall, the surface
    Point nearest{0, std::numeric_limits<double>::infinity()};
    for (const Join& join : joins) {
      Point at{};
      if (crossing(join, 1, -tangent, 0, at) && at.z > 0) {
        const bool nearer = at.z < nearest.z - kTouch;
        const bool better = seen != nullptr && seen->wall && !join.wall && at.z < nearest.z + kTouch;
        if (nearer || better) {
          seen = &join;
          nearest = at;
        }
      }
    }
    const bool valid = seen != nullptr && !seen->wall && is_lit(rig, joins, nearest);
    reference.valid[i] = valid ? 1 : 0;
    reference.z_mm[i] = valid ? nearest.z : kUnknown;
    reference.tan_theta[i] = valid ? rig.projector.x_mm / (nearest.z - rig.projector.z_mm) : kUnknown;  // (3.8)
    reference.offset_px[i] = valid ? 0 : kUnknown;
  }
  return reference;
}

ReferenceProfile reference_of_straight_line(const Rig& rig, double line, std::span<const double> centroid) {
  expect_columns(rig, centroid.size());
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
  const RigProjector& projector = rig.projector;
  const std::vector<Join> joins = joins_of(curve);
  std::vector<double> lines(static_cast<std::size_t>(projector.columns), kUnknown);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double yp =
        projector.center_yp_mm + projector.column_pitch_mm * (static_cast<double>(i) - 0.5 * (projector.columns - 1));
    // The points of the plane x = 0 that the column lights: y fp = Yp ((z - z0) cos θ0 + x0 sin θ0).
    const double slope = yp * std::cos(projector.tilt_rad);
    const double level = yp * projector_depth(projector, 0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Join& join : joins) {
      Point at{};
      if (!join.wall && crossing(join, projector.focal_length_mm, -slope, level, at) && at.z < nearest &&
          is_lit(rig, joins, at) && !hidden(joins, 0, at)) {
        nearest = at.z;
        lines[i] = line_on_middle(projector, at.z);
      }
    }
  }
  return lines;
}

}  // namespace selfproj
