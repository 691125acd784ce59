// The bodies of a scene during the exposure of a frame, and the blocks of the image in which they matter.
#ifndef SELFPROJ_SIM_SCENE_BODY_MOTION_H
#define SELFPROJ_SIM_SCENE_BODY_MOTION_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/body.h"
#include "sim/scene/scene.h"
#include "sim/scene/still_surface.h"

namespace selfproj {

// The exposure is sampled at kSubPixels (lens_kernel.h) * passes instants, each sub-pixel at `passes` of them. Without
// bodies, `instants` and the masks are empty.
struct BodyMotion {
  int passes = 1;
  std::array<Bodies, 3> ends;    // at the beginning, middle and end of the exposure
  std::vector<Bodies> instants;  // the bodies at each of these instants
  // For each block, bit i of `seen` is set if body i may be seen in it, and bit i of `shaded` if the shadow of body i
  // may fall on what is seen in it.
  std::vector<std::uint32_t> seen;
  std::vector<std::uint32_t> shaded;

  // Whether bodies may matter in a block.
  [[nodiscard]] bool touches(std::size_t block) const { return !seen.empty() && (seen[block] | shaded[block]) != 0; }
};

// `middle` and `exposure` are in s; an exposure of 0 is an instant.
BodyMotion body_motion(const Rig& rig, const Scene& scene, const StillSurface& still, double middle, double exposure);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BODY_MOTION_H
