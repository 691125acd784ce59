// Experiment B2: how fast waves run on water.
#ifndef SELFPROJ_SIM_EXPERIMENT_POOL_EXPERIMENT_H
#define SELFPROJ_SIM_EXPERIMENT_POOL_EXPERIMENT_H

#include "sim/experiment/gray_observation.h"
#include "sim/experiment/structured_light.h"

namespace selfproj {

// The tables of B2, and what is not reached: the speed of long waves within 5 % of sqrt(g depth) in every pool.
StructuredLightResult run_waves(const GrayMotionOptions& options, const ProgressOfImages& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_POOL_EXPERIMENT_H
