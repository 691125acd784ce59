// B4 of the thesis in simulation: cuboids of different heights under self-projected structured light, beside the
// conventional method.
#ifndef SELFPROJ_SIM_EXPERIMENT_CUBOIDS_H
#define SELFPROJ_SIM_EXPERIMENT_CUBOIDS_H

#include <vector>

#include "host/rig/rig.h"
#include "host/structured_light/stripe_code.h"
#include "sim/experiment/structured_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_scan.h"

namespace selfproj {

struct CuboidsOptions {
  Rig rig;
  RenderOptions render;
  ScanMethod scan = ScanMethod::lines;
  int e = 8;  // (4.20)
  Stripes stripes;
  std::vector<int> conventional_bits{8, 7, 6, 5, 4};  // the conventional method is measured with each
};

// The reference, `cuboids`, is scanned; `cuboids-marked` is measured under the patterns made of it.
StructuredLightResult run_cuboids(const CuboidsOptions& options, const ProgressOfImages& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_CUBOIDS_H
