// The geometry of camera and projector (docs/rigs.md), in double precision. Lengths are in mm. Rows of a centroid
// count from 1 as in (3.2); columns and projector lines count from 0 as in files.
#ifndef SELFPROJ_HOST_RIG_GEOMETRY_H
#define SELFPROJ_HOST_RIG_GEOMETRY_H

#include <cmath>
#include <limits>

#include "selfproj/rig/rig.h"

namespace selfproj::rig {

// Stands for a value that is not known.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// The centroid of a line on Xc = 0: the middle row of the image, from 1.
inline double middle_row(const RigCamera& camera) { return 0.5 * (camera.rows + 1); }

// tan α of a centroid, which is a row from 1 (3.3, 3.6), and the inverse.
inline double tan_alpha(const RigCamera& camera, double centroid) {
  return camera.pixel_pitch_mm * (centroid - middle_row(camera)) / camera.focal_length_mm;
}
inline double centroid_of(const RigCamera& camera, double tan_alpha) {
  return middle_row(camera) + tan_alpha * camera.focal_length_mm / camera.pixel_pitch_mm;
}

// tan β of a column from 0 (3.3, 3.6), and the inverse.
inline double tan_beta(const RigCamera& camera, double column) {
  return camera.pixel_pitch_mm * (column - 0.5 * (camera.columns - 1)) / camera.focal_length_mm;
}
inline double column_of(const RigCamera& camera, double tan_beta) {
  return 0.5 * (camera.columns - 1) + tan_beta * camera.focal_length_mm / camera.pixel_pitch_mm;
}

// tan θ of a projector line from 0, with a fraction (3.7), and the inverse.
inline double tan_theta(const RigProjector& projector, double line) {
  const double xp = projector.center_xp_mm + projector.line_pitch_mm * (line - 0.5 * (projector.lines - 1));
  return std::tan(projector.tilt_rad + std::atan(xp / projector.focal_length_mm));
}
inline double line_of(const RigProjector& projector, double tan_theta) {
  const double xp = projector.focal_length_mm * std::tan(std::atan(tan_theta) - projector.tilt_rad);
  return 0.5 * (projector.lines - 1) + (xp - projector.center_xp_mm) / projector.line_pitch_mm;
}

// Depth of a point of the plane x = 0 along the projector's axis. The point is in front of the projector if it is > 0.
inline double projector_depth(const RigProjector& projector, double z) {
  return (z - projector.z_mm) * std::cos(projector.tilt_rad) + projector.x_mm * std::sin(projector.tilt_rad);
}

// The projector line, from 0 with a fraction, that lights the point (0, y, z): (3.9), corrected, as the printed
// denominator lacks x0. It does not depend on y. The point's depth along the projector's axis must be > 0.
inline double line_on_middle(const RigProjector& projector, double z) {
  const double tilt = std::tan(projector.tilt_rad);
  const double depth = z - projector.z_mm;
  const double xp = projector.focal_length_mm * (projector.x_mm - depth * tilt) / (depth + projector.x_mm * tilt);
  return 0.5 * (projector.lines - 1) + (xp - projector.center_xp_mm) / projector.line_pitch_mm;
}

// The projector column, from 0 with a fraction, that lights (0, y, z). It follows from the exact relation
//     y = (z - z0) Yp / (fp cos θ0 - Xp sin θ0)                       (3.5, 3.8, 3.9, y part, corrected)
// which with Xp of (3.9) is y = Yp (depth along the projector's axis) / fp.
inline double projector_column_on_middle(const RigProjector& projector, double y, double z) {
  const double yp = y * projector.focal_length_mm / projector_depth(projector, z);
  return 0.5 * (projector.columns - 1) + (yp - projector.center_yp_mm) / projector.column_pitch_mm;
}

}  // namespace selfproj::rig

#endif  // SELFPROJ_HOST_RIG_GEOMETRY_H
