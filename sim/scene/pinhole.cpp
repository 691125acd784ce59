#include "sim/scene/pinhole.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "host/rig/rig.h"

namespace selfproj {

Pinhole::Pinhole(Point3 centre, const std::array<Point3, 3>& axes, const Intrinsics& k)
    : centre_(centre), axes_(axes), k_(k) {
  // K R: each row is the direction of a pixel axis, scaled, plus the optical axis times the principal point.
  const std::array<Point3, 3> kr{k.row_scale * axes[0] + k.row_0 * axes[2],
                                 k.column_scale * axes[1] + k.column_0 * axes[2], axes[2]};
  for (std::size_t i = 0; i < kr.size(); ++i) {
    matrix_[i] = {kr[i].x, kr[i].y, kr[i].z, -dot(kr[i], centre)};
  }
}

Pinhole Pinhole::of_camera(const RigCamera& camera) {
  const double scale = camera.focal_length_mm / camera.pixel_pitch_mm;
  return {{0, 0, 0},
          {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
          {scale, scale, (camera.rows - 1) / 2.0, (camera.columns - 1) / 2.0}};
}

// The axis, tilted from z towards −x, is (−sin θ0, 0, cos θ0). Xp grows in the direction in which it turns as θ0 grows.
Pinhole Pinhole::of_projector(const RigProjector& projector) {
  const double s = std::sin(projector.tilt_rad);
  const double c = std::cos(projector.tilt_rad);
  return {{projector.x_mm, 0, projector.z_mm},
          {{{-c, 0, -s}, {0, 1, 0}, {-s, 0, c}}},
          {projector.focal_length_mm / projector.line_pitch_mm, projector.focal_length_mm / projector.column_pitch_mm,
           (projector.lines - 1) / 2.0 - projector.center_xp_mm / projector.line_pitch_mm,
           (projector.columns - 1) / 2.0 - projector.center_yp_mm / projector.column_pitch_mm}};
}

Point3 Pinhole::ray(PixelPoint pixel) const {
  return (pixel.row - k_.row_0) / k_.row_scale * axes_[0] + (pixel.column - k_.column_0) / k_.column_scale * axes_[1] +
         axes_[2];
}

}  // namespace selfproj
