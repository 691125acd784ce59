// The straight pieces of a reference's section, and what of them can be seen from a point.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_SECTION_JOINS_H
#define SELFPROJ_HOST_LIGHT_SECTION_SECTION_JOINS_H

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "host/light_section/reference_profile.h"

namespace selfproj {

// Millimetres. A wall that begins where a surface ends does not hide that end.
inline constexpr double kTouch = 1e-6;

struct SectionPoint {
  double y;
  double z;
};

// The straight piece between two neighbours of a curve.
struct SectionJoin {
  SectionPoint a;
  SectionPoint b;
  bool wall;
};

inline std::vector<SectionJoin> joins_of(const ReferenceCurve& curve) {
  std::vector<SectionJoin> joins;
  for (std::size_t i = 0; i + 1 < curve.y_mm.size(); ++i) {
    const SectionPoint a{curve.y_mm[i], curve.z_mm[i]};
    const SectionPoint b{curve.y_mm[i + 1], curve.z_mm[i + 1]};
    if (std::isfinite(a.y) && std::isfinite(a.z) && std::isfinite(b.y) && std::isfinite(b.z)) {
      joins.push_back({a, b, std::abs(b.z - a.z) > kSteepest * std::abs(b.y - a.y)});
    }
  }
  return joins;
}

// Where the join meets the straight line p y + q z = r, if it does.
inline bool crossing(const SectionJoin& join, double p, double q, double r, SectionPoint& at) {
  const double a = p * join.a.y + q * join.a.z - r;
  const double b = p * join.b.y + q * join.b.z - r;
  if ((a > 0 && b > 0) || (a < 0 && b < 0) || (a == 0 && b == 0)) {
    return false;
  }
  const double t = a / (a - b);
  at = {join.a.y + t * (join.b.y - join.a.y), join.a.z + t * (join.b.z - join.a.z)};
  return true;
}

// Whether a part of the curve lies between the viewpoint and the point, seen along x.
inline bool hidden(const std::vector<SectionJoin>& joins, const SectionPoint& viewpoint, const SectionPoint& point) {
  const double depth = point.z - viewpoint.z;
  const double side = point.y - viewpoint.y;
  for (const SectionJoin& join : joins) {
    SectionPoint at{};
    if (crossing(join, depth, -side, depth * viewpoint.y - side * viewpoint.z, at) && at.z > viewpoint.z &&
        at.z < point.z - kTouch) {
      return true;
    }
  }
  return false;
}

// What a camera column sees of the section: the nearest join with y = z tan β, and where. If a surface ends at a wall,
// it is the surface. Null if there is none.
struct SectionSight {
  const SectionJoin* join = nullptr;
  SectionPoint at{0, std::numeric_limits<double>::infinity()};
};
inline SectionSight sight_along(const std::vector<SectionJoin>& joins, double tan_beta) {
  SectionSight sight;
  for (const SectionJoin& join : joins) {
    SectionPoint at{};
    if (crossing(join, 1, -tan_beta, 0, at) && at.z > 0) {
      const bool nearer = at.z < sight.at.z - kTouch;
      const bool better = sight.join != nullptr && sight.join->wall && !join.wall && at.z < sight.at.z + kTouch;
      if (nearer || better) {
        sight = {&join, at};
      }
    }
  }
  return sight;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_SECTION_JOINS_H
