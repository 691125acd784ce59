// A co-simulation of a light section: it measures the differential profile of every frame, or only the moments if the
// geometry is unknown.
#ifndef SELFPROJ_SIM_EXPERIMENT_COSIM_LIGHT_SECTION_H
#define SELFPROJ_SIM_EXPERIMENT_COSIM_LIGHT_SECTION_H

#include <memory>

#include "sim/experiment/cosim_measurement.h"
#include "sim/experiment/cosim_options.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// For a scene under the simulated camera, with its reference's pattern. Both functions throw UserError about bad
// options or input.
std::unique_ptr<CosimMeasurement> make_light_section_cosim(const CosimOptions& options, const SceneInfo& scene);

// For recorded images. With a rig they are measured from the straight line that lies on the middle row where it meets
// the plane. Without one the result is moments and centroids.
std::unique_ptr<CosimMeasurement> make_recorded_cosim(const CosimOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_COSIM_LIGHT_SECTION_H
