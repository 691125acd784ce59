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

struct BodyMotion {
  int passes = 1;                // how many instants each sub-pixel is sampled at
  std::array<Bodies, 3> ends;    // at the beginning, middle and end of the exposure
  std::vector<Bodies> instants;  // at each of the kSubPixels * passes instants
  // For each block a mask of the bodies that may be seen in it, and a mask of those whose shadows may fall on what is
  // seen in it. Empty if the scene has no bodies.
  std::vector<std::uint32_t> seen;
  std::vector<std::uint32_t> shaded;

  // Whether bodies may matter in a block.
  [[nodiscard]] bool touches(std::size_t block) const { return !seen.empty() && (seen[block] | shaded[block]) != 0; }
};

// `middle` and `exposure` are in s; an exposure of 0 is an instant.
BodyMotion body_motion(const Rig& rig, const Scene& scene, const StillSurface& still, double middle, double exposure);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BODY_MOTION_H
