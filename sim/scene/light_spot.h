// The point that a ray of the camera meets, with the properties on which images under patterns depend.
#ifndef SELFPROJ_SIM_SCENE_LIGHT_SPOT_H
#define SELFPROJ_SIM_SCENE_LIGHT_SPOT_H

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sim/scene/projected_light.h"

namespace selfproj {

struct LightSpot {
  float z = 0;                 // mm
  float line = 0, column = 0;  // place in the projector's image
  float light = 0;             // grey values added by full light of the projector; 0 in the shadow
  float ambient = 0;           // grey values without the projector

  // The grey value under a pattern.
  [[nodiscard]] float grey(const ProjectedLight& pattern) const {
    return light == 0 ? ambient : ambient + light * pattern.quick_at(line, column, z);
  }
};

inline float mix(float a, float b, float share) { return a + share * (b - a); }

inline LightSpot mix(const LightSpot& a, const LightSpot& b, float share) {
  return {mix(a.z, b.z, share), mix(a.line, b.line, share), mix(a.column, b.column, share),
          mix(a.light, b.light, share), mix(a.ambient, b.ambient, share)};
}

// In this order: upper left, upper right, lower left, lower right.
using SpotCorners = std::array<LightSpot, 4>;

// Linear between the corners. `down` and `across` are shares 0..1.
inline LightSpot between(const SpotCorners& corners, float down, float across) {
  return mix(mix(corners[0], corners[2], down), mix(corners[1], corners[3], down), across);
}

// Whether no member differs by more than the same member of `tolerance`.
inline bool alike(const LightSpot& a, const LightSpot& b, const LightSpot& tolerance) {
  return std::abs(a.z - b.z) <= tolerance.z && std::abs(a.line - b.line) <= tolerance.line &&
         std::abs(a.column - b.column) <= tolerance.column && std::abs(a.light - b.light) <= tolerance.light &&
         std::abs(a.ambient - b.ambient) <= tolerance.ambient;
}

// Bounds of the projector's lines and columns that light several spots.
struct SpotBounds {
  float line_0 = std::numeric_limits<float>::max();
  float line_1 = std::numeric_limits<float>::lowest();
  float column_0 = std::numeric_limits<float>::max();
  float column_1 = std::numeric_limits<float>::lowest();

  void add(const LightSpot& spot) {
    line_0 = std::min(line_0, spot.line);
    line_1 = std::max(line_1, spot.line);
    column_0 = std::min(column_0, spot.column);
    column_1 = std::max(column_1, spot.column);
  }

  // Bounds of a pattern's light in that rectangle.
  [[nodiscard]] MinMaxPyramid::Range light_of(const ProjectedLight& pattern) const {
    return pattern.range(static_cast<double>(line_0), static_cast<double>(line_1), static_cast<double>(column_0),
                         static_cast<double>(column_1));
  }
};

// If light varies over a block by no more than this, it counts as one value.
inline constexpr float kSameLight = 1e-4F;

// How far the contents of a block may deviate from linear for its corners to represent it.
inline constexpr float kPlaceTolerance = 0.02F;  // projector lines and columns
inline constexpr float kGreyTolerance = 0.2F;
inline constexpr float kDepthTolerance = 0.05F;  // mm

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_LIGHT_SPOT_H
