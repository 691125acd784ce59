// Experiment B2: how fast waves run on water.
#ifndef SELFPROJ_LAB_POOL_EXPERIMENT_H
#define SELFPROJ_LAB_POOL_EXPERIMENT_H

#include "lab/gray_observation.h"
#include "lab/structured_light.h"

namespace selfproj {

// Returns the tables of B2, and which pools do not reach the goal: the speed of long waves must be within 5 % of
// sqrt(g depth).
StructuredLightResult run_waves(const GrayMotionOptions& options, const ProgressOfImages& progress);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_POOL_EXPERIMENT_H
