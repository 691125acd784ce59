// Camera and projector as pinholes, by vectors and directly from the definitions of include/selfproj/rig/rig.h.
// host/structured_light is tested against them.
#ifndef SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_PINHOLE_H
#define SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_PINHOLE_H

#include <cmath>

#include "selfproj/rig/rig.h"

namespace selfproj::test {

struct Point3 {
  double x;
  double y;
  double z;
};

// Coordinates in an image, from 0: row and column of the camera, or line and column of the projector.
struct Pixel {
  double row;
  double column;
};

inline Pixel camera_sees(const rig::RigCamera& camera, const Point3& p) {
  return {0.5 * (camera.rows - 1) + camera.focal_length_mm * p.x / p.z / camera.pixel_pitch_mm,
          0.5 * (camera.columns - 1) + camera.focal_length_mm * p.y / p.z / camera.pixel_pitch_mm};
}

inline Pixel projector_lights(const rig::RigProjector& projector, const Point3& p) {
  const double sine = std::sin(projector.tilt_rad);
  const double cosine = std::cos(projector.tilt_rad);
  const double x = p.x - projector.x_mm;
  const double z = p.z - projector.z_mm;
  const double depth = -sine * x + cosine * z;  // the axis is tilted from z towards -x
  const double side = -cosine * x - sine * z;   // Xp grows with θ, that is towards -x
  const double xp = projector.focal_length_mm * side / depth;
  const double yp = projector.focal_length_mm * p.y / depth;
  return {0.5 * (projector.lines - 1) + (xp - projector.center_xp_mm) / projector.line_pitch_mm,
          0.5 * (projector.columns - 1) + (yp - projector.center_yp_mm) / projector.column_pitch_mm};
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_PINHOLE_H
