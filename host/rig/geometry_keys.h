// The numbers of a rig that its references depend on, with their names in files.
#ifndef SELFPROJ_HOST_RIG_GEOMETRY_KEYS_H
#define SELFPROJ_HOST_RIG_GEOMETRY_KEYS_H

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "host/rig/rig.h"

namespace selfproj {

inline void add_lens(const std::string& section, const RigLens& lens,
                     std::vector<std::pair<std::string, double>>& keys) {
  keys.insert(keys.end(), {{section + ".fx_px", lens.fx_px},
                           {section + ".fy_px", lens.fy_px},
                           {section + ".cx_px", lens.cx_px},
                           {section + ".cy_px", lens.cy_px},
                           {section + ".k1", lens.k1},
                           {section + ".k2", lens.k2},
                           {section + ".p1", lens.p1},
                           {section + ".p2", lens.p2},
                           {section + ".k3", lens.k3}});
}

// Of a laser line: camera and plane. Of a calibrated rig: also lenses and pose. Of corrected heights: the corrections.
inline std::vector<std::pair<std::string, double>> geometry_of(const Rig& rig) {
  std::vector<std::pair<std::string, double>> keys = {{"camera.rows", rig.camera.rows},
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
  if (rig.calibration) {
    add_lens("camera_lens", rig.calibration->camera, keys);
  }
  if (rig.calibration && !rig.light_plane) {
    const std::array<double, 3>& turn = rig.calibration->rotation_rad;
    const std::array<double, 3>& move = rig.calibration->translation_mm;
    add_lens("projector_lens", rig.calibration->projector, keys);
    keys.insert(keys.end(), {{"projector_pose.rotation_x_rad", turn[0]},
                             {"projector_pose.rotation_y_rad", turn[1]},
                             {"projector_pose.rotation_z_rad", turn[2]},
                             {"projector_pose.translation_x_mm", move[0]},
                             {"projector_pose.translation_y_mm", move[1]},
                             {"projector_pose.translation_z_mm", move[2]}});
  }
  if (rig.light_plane) {
    keys.insert(keys.end(), {{"light_plane.normal_x", rig.light_plane->normal[0]},
                             {"light_plane.normal_y", rig.light_plane->normal[1]},
                             {"light_plane.normal_z", rig.light_plane->normal[2]},
                             {"light_plane.distance_mm", rig.light_plane->distance_mm}});
  }
  if (rig.belt_pose) {
    const auto& [direction, normal] = *rig.belt_pose;
    keys.insert(keys.end(), {{"belt_pose.direction_x", direction[0]},
                             {"belt_pose.direction_y", direction[1]},
                             {"belt_pose.direction_z", direction[2]},
                             {"belt_pose.normal_x", normal[0]},
                             {"belt_pose.normal_y", normal[1]},
                             {"belt_pose.normal_z", normal[2]}});
  }
  if (rig.heights) {
    keys.insert(keys.end(), {{"plane_z_mm", rig.plane_z_mm},
                             {"heights.lowest_mm", rig.heights->lowest_mm},
                             {"heights.highest_mm", rig.heights->highest_mm},
                             {"heights.order", rig.heights->order},
                             {"heights.order_heights", rig.heights->order_heights}});
    for (std::size_t i = 0; i < rig.heights->corrections_mm.size(); ++i) {
      keys.emplace_back("heights.corrections_mm." + std::to_string(i + 1), rig.heights->corrections_mm[i]);
    }
  }
  return keys;
}

// Numbers are written so that they read back to the same value. A rig that went through its YAML may differ in the last
// digit.
inline bool same_geometry(double a, double b) { return std::abs(a - b) <= 1e-12 * std::max(std::abs(a), std::abs(b)); }

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_GEOMETRY_KEYS_H
