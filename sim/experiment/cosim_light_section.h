// What a co-simulation measures by a light section: the differential profile of every frame, or the moments alone where
// nothing is known of the geometry.
#ifndef SELFPROJ_SIM_EXPERIMENT_COSIM_LIGHT_SECTION_H
#define SELFPROJ_SIM_EXPERIMENT_COSIM_LIGHT_SECTION_H

#include <memory>

#include "sim/experiment/cosim_measurement.h"
#include "sim/experiment/cosim_options.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// A scene under the simulated camera, its reference's pattern projected. All of these throw UserError naming what is
// wrong.
std::unique_ptr<CosimMeasurement> make_light_section_cosim(const CosimOptions& options, const SceneInfo& scene);

// Recorded images. With a rig they are measured from the straight line that lies on the middle row where it meets the
// plane; without one moments and centroids come out.
std::unique_ptr<CosimMeasurement> make_recorded_cosim(const CosimOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_COSIM_LIGHT_SECTION_H
