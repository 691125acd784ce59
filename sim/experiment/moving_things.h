// Experiments B7 (mouse on a slider) and B8 (two hands): self-projected structured light of moving things, 500 depth
// images a second of simulated time.
#ifndef SELFPROJ_SIM_EXPERIMENT_MOVING_THINGS_H
#define SELFPROJ_SIM_EXPERIMENT_MOVING_THINGS_H

#include <string>

#include "host/rig/rig.h"
#include "sim/experiment/structured_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_scan.h"

namespace selfproj {

// Makes a depth image after every pair of images. The conventional method with 8 bits measures the same frames beside
// the self-projected codes of 4 bits. Both also measure the things at rest, where they were in the middle of a window
// of 2m frames; this shows what motion adds.
struct MovingOptions {
  Rig rig;
  RenderOptions render;
  ScanMethod scan = ScanMethod::lines;  // scan of the reference
  int e = 0;                            // e of (4.20)
  int first = 0;                        // first frame
  int pairs = 0;                        // depth images by each method; 0: all of the scene from `first` on
  int strips = 10;  // pictures of each method, or a few more; things are also measured at rest at these instants
};

// `name` is "B7" or "B8". In the result, `series` has one row of figures for each depth image and thing. Throws
// std::invalid_argument if the scene has too few frames, or e is out of range.
StructuredLightResult run_moving(const std::string& name, const MovingOptions& options,
                                 const ProgressOfImages& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_MOVING_THINGS_H
