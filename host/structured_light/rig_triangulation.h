// Triangulation by a rig, through its lenses if it is calibrated.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_RIG_TRIANGULATION_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_RIG_TRIANGULATION_H

#include <memory>

#include "host/rig/rig.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

// Codes of `bits` bits along the lines of the rig's projector, for images of its camera; its max_z_per_line_mm takes
// the place of that of `limits`. Throws std::invalid_argument as the triangulations do.
std::unique_ptr<Triangulation> triangulation_of_rig(const Rig& rig, int bits, const DepthLimits& limits = {});

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_RIG_TRIANGULATION_H
