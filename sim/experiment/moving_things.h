// B7 (mouse on a slider) and B8 (two hands) of the thesis: self-projected structured light of what moves, 500 depth
// images a second of simulated time.
#ifndef SELFPROJ_SIM_EXPERIMENT_MOVING_THINGS_H
#define SELFPROJ_SIM_EXPERIMENT_MOVING_THINGS_H

#include <string>

#include "host/rig/rig.h"
#include "sim/experiment/structured_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_scan.h"

namespace selfproj {

// A depth image after every pair of images; beside the self-projected codes of 4 bits the conventional method with 8
// bits over the same frames, and both with the things standing still where they were in the middle of a window of 2m
// frames, which shows what motion adds.
struct MovingOptions {
  Rig rig;
  RenderOptions render;
  ScanMethod scan = ScanMethod::lines;  // of the reference
  int e = 0;                            // (4.20)
  int first = 0;                        // frame
  int pairs = 0;                        // depth images by each method; 0: all of the scene from `first` on
  int strips = 10;  // pictures of each method, or a few more; at their instants things are also measured at rest
};

// `name` is "B7" or "B8". The result has a row of figures a depth image and thing (`series`). Throws
// std::invalid_argument where the scene has not so many frames, or e is out of range.
StructuredLightResult run_moving(const std::string& name, const MovingOptions& options,
                                 const ProgressOfImages& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_MOVING_THINGS_H
