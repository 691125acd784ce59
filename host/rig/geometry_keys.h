// The numbers of a rig that its references depend on, with their names in files.
#ifndef SELFPROJ_HOST_RIG_GEOMETRY_KEYS_H
#define SELFPROJ_HOST_RIG_GEOMETRY_KEYS_H

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "host/rig/rig.h"

namespace selfproj {

inline std::vector<std::pair<std::string, double>> geometry_of(const Rig& rig) {
  return {{"camera.rows", rig.camera.rows},
          {"camera.columns", rig.camera.columns},
          {"camera.pixel_pitch_mm", rig.camera.pixel_pitch_mm},
          {"camera.focal_length_mm", rig.camera.focal_length_mm},
          {"projector.x_mm", rig.projector.x_mm},
          {"projector.z_mm", rig.projector.z_mm},
          {"projector.tilt_rad", rig.projector.tilt_rad},
          {"projector.focal_length_mm", rig.projector.focal_length_mm},
          {"projector.lines", rig.projector.lines},
          {"projector.columns", rig.projector.columns},
          {"projector.line_pitch_mm", rig.projector.line_pitch_mm},
          {"projector.column_pitch_mm", rig.projector.column_pitch_mm},
          {"projector.center_xp_mm", rig.projector.center_xp_mm},
          {"projector.center_yp_mm", rig.projector.center_yp_mm}};
}

// Numbers are written so that they read back to the same value. A rig that went through its YAML may differ in the last
// digit.
inline bool same_geometry(double a, double b) { return std::abs(a - b) <= 1e-12 * std::max(std::abs(a), std::abs(b)); }

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_GEOMETRY_KEYS_H
