// The views of a surface z(x, y) by camera and projector of a rig, computed with rays and pinholes independently of the
// host's code.
#ifndef SELFPROJ_TESTS_HOST_LIGHT_SECTION_SEEN_SURFACE_H
#define SELFPROJ_TESTS_HOST_LIGHT_SECTION_SEEN_SURFACE_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>

#include "host/structured_light/point_scan.h"
#include "selfproj/rig/rig.h"
#include "tests/host/structured_light/pinhole.h"

namespace selfproj::test {

// z of the surface at (x, y), mm.
using Surface = std::function<double(double x, double y)>;

inline Surface plane_at(double z) {
  return [z](double, double) { return z; };
}

// The rig `scanner` with pixels of camera and projector `factor` times as large, and fewer of them.
inline rig::Rig coarse_scanner(int factor) {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows /= factor;
  rig.camera.columns /= factor;
  rig.camera.pixel_pitch_mm *= factor;
  rig.projector.lines /= factor;
  rig.projector.columns /= factor;
  rig.projector.line_pitch_mm *= factor;
  rig.projector.column_pitch_mm *= factor;
  return rig;
}

inline Point3 on_ray(const rig::RigCamera& camera, double row, double column, double z) {
  const double scale = z * camera.pixel_pitch_mm / camera.focal_length_mm;
  return {(row - 0.5 * (camera.rows - 1)) * scale, (column - 0.5 * (camera.columns - 1)) * scale, z};
}

// The first point of the surface on the ray of a camera pixel, between z = near and z = far, found by steps of `step`
// mm of z and bisection; none if the ray does not meet it.
inline std::optional<Point3> seen_point(const rig::RigCamera& camera, double row, double column, const Surface& surface,
                                        double near, double far, double step) {
  const auto below = [&](double z) {
    const Point3 p = on_ray(camera, row, column, z);
    return p.z >= surface(p.x, p.y);
  };
  double low = near;
  while (!below(low + step)) {
    low += step;
    if (low >= far) {
      return std::nullopt;
    }
  }
  double high = low + step;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (below(middle) ? high : low) = middle;
  }
  return on_ray(camera, row, column, high);
}

// Whether the surface lies between the point and the projector.
inline bool in_shadow(const rig::RigProjector& projector, const Point3& p, const Surface& surface) {
  constexpr int kSteps = 400;
  for (int i = 1; i < kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    const Point3 q{p.x + t * (projector.x_mm - p.x), p.y * (1 - t), p.z + t * (projector.z_mm - p.z)};
    if (q.z > surface(q.x, q.y) + 0.01) {
      return true;
    }
  }
  return false;
}

inline bool within(const rig::RigProjector& projector, const Pixel& p) {
  return p.row >= -0.5 && p.row < projector.lines - 0.5 && p.column >= -0.5 && p.column < projector.columns - 0.5;
}

// X_R of the surface without error; NaN where no light falls.
inline structured_light::ProjectorPoints points_of(const rig::Rig& rig, const Surface& surface, double near = 400,
                                                   double far = 620, double step = 5) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  structured_light::ProjectorPoints points{images::FloatImage(rig.camera.rows, rig.camera.columns, nan),
                                           images::FloatImage(rig.camera.rows, rig.camera.columns, nan)};
  for (int r = 0; r < rig.camera.rows; ++r) {
    for (int c = 0; c < rig.camera.columns; ++c) {
      const auto p = seen_point(rig.camera, r, c, surface, near, far, step);
      if (!p || in_shadow(rig.projector, *p, surface)) {
        continue;
      }
      const Pixel lit = projector_lights(rig.projector, *p);
      if (within(rig.projector, lit)) {
        points.line.row(r)[c] = static_cast<float>(lit.row);
        points.column.row(r)[c] = static_cast<float>(lit.column);
      }
    }
  }
  return points;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_LIGHT_SECTION_SEEN_SURFACE_H
