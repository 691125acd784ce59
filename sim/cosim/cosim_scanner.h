// A co-simulation of Gray codes: it measures depth images, and what moves in them in front of a background.
#ifndef SELFPROJ_SIM_COSIM_COSIM_SCANNER_H
#define SELFPROJ_SIM_COSIM_COSIM_SCANNER_H

#include <memory>

#include "sim/cosim/cosim_measurement.h"
#include "sim/cosim/cosim_options.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// For a scene of method gray_codes. Options and scene must outlive the result. Throws UserError about the options.
std::unique_ptr<CosimMeasurement> make_scanner_cosim(const CosimOptions& options, const SceneInfo& scene);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_COSIM_SCANNER_H
