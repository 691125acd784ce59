// Experiments B7 (mouse on a slider) and B8 (two hands): self-projected structured light of moving things, 500 depth
// images a second of simulated time.
#ifndef SELFPROJ_LAB_MOVING_THINGS_H
#define SELFPROJ_LAB_MOVING_THINGS_H

#include <string>

#include "host/rig/rig.h"
#include "lab/structured_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_scan.h"

namespace selfproj {

// The experiment makes a depth image after every pair of images. It compares two methods on the same motion:
// conventional Gray codes of 8 bits, and self-projected codes of 4 bits. Each method also measures the things at rest,
// at their position in the middle of a window of 2m frames, where m is the number of bits. The difference is the error
// from motion.
struct MovingOptions {
  Rig rig;
  RenderOptions render;
  ScanMethod scan = ScanMethod::lines;  // how the reference is scanned
  int e = 0;                            // e of (4.20) in the thesis: cells below the reference that are searched
  int first = 0;                        // first frame
  int pairs = 0;                        // depth images by each method; 0: all of the scene from `first` on
  int strips = 10;  // pictures by each method, or a few more; at these instants things are also measured at rest
};

// `name` is "B7" or "B8". In the result, `series` has one row of figures for each depth image and thing. Throws
// std::invalid_argument if the scene has too few frames, or e is out of range.
StructuredLightResult run_moving(const std::string& name, const MovingOptions& options,
                                 const ProgressOfImages& progress);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_MOVING_THINGS_H
