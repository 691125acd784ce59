// Finds where rays meet the surface of a scene, using only the bounds that it gives of its heights. Exact for smooth
// slopes and vertical faces alike, and without stepping along the ray.
#ifndef SELFPROJ_SIM_SCENE_RAY_H
#define SELFPROJ_SIM_SCENE_RAY_H

#include "sim/scene/scene.h"

namespace selfproj {

// A straight line, given by its place at each height h above the plane: (x + dx h, y + dy h).
struct HeightRay {
  double x, dx;
  double y, dy;
};

// The tolerance of heights, mm.
constexpr double kHeightTolerance = 1e-4;

// The greatest height in low..high, mm, at which the ray, coming from above, is at or below the surface at the time t;
// `low` if there is none. Never below the surface's least height along the ray, if that is at least `low`.
double first_hit(const Scene& scene, const HeightRay& ray, double t, double low, double high);

// Whether the surface rises above the ray anywhere between the heights low and high.
bool is_blocked(const Scene& scene, const HeightRay& ray, double t, double low, double high);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_RAY_H
