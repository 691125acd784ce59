// A co-simulation of a light section: it measures the differential profile of every frame, or only the moments if the
// geometry is unknown.
#ifndef SELFPROJ_SIM_COSIM_COSIM_LIGHT_SECTION_H
#define SELFPROJ_SIM_COSIM_COSIM_LIGHT_SECTION_H

#include <memory>

#include "sim/cosim/cosim_measurement.h"
#include "sim/cosim/cosim_options.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// For a scene under the simulated camera. The pattern is computed from the scene's reference. Both functions throw
// UserError about bad options or input.
std::unique_ptr<CosimMeasurement> make_light_section_cosim(const CosimOptions& options, const SceneInfo& scene);

// For recorded images. With --rig, profiles are measured from the empty plane under a straight line, which is assumed
// to lie on the middle row where it meets the plane. Without --rig, the result is moments and centroids.
std::unique_ptr<CosimMeasurement> make_recorded_cosim(const CosimOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_COSIM_LIGHT_SECTION_H
