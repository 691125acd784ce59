// A co-simulation of self-projected structured light. The scene's reference is scanned by Gray codes, and patterns and
// match table are made from the scan. The board's code images, as the driver gives them, go through the matching block.
// Its lines are compared with model/gray_match and with the host's own for every pixel.
#ifndef SELFPROJ_SIM_COSIM_COSIM_SELF_PROJECTED_H
#define SELFPROJ_SIM_COSIM_COSIM_SELF_PROJECTED_H

#include <memory>

#include "sim/cosim/cosim_measurement.h"
#include "sim/cosim/cosim_options.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// For a scene of method self_projected. Options and scene must outlive the result. Throws UserError about the options.
std::unique_ptr<CosimMeasurement> make_self_projected_cosim(const CosimOptions& options, const SceneInfo& scene);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_COSIM_SELF_PROJECTED_H
