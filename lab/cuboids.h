// Experiment B4 in simulation: cuboids of different heights under self-projected structured light, compared with the
// conventional method.
#ifndef SELFPROJ_LAB_CUBOIDS_H
#define SELFPROJ_LAB_CUBOIDS_H

#include <vector>

#include "host/rig/rig.h"
#include "host/structured_light/self_reference.h"
#include "lab/structured_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_scan.h"

namespace selfproj {

struct CuboidsOptions {
  Rig rig;
  RenderOptions render;
  ScanMethod scan = ScanMethod::lines;
  int e = 8;  // e of (4.20)
  Stripes stripes;
  std::vector<int> conventional_bits{8, 7, 6, 5, 4};  // the numbers of bits for the conventional method
};

// Scans the reference, `cuboids`, and measures `cuboids-marked` under the patterns made from the scan.
StructuredLightResult run_cuboids(const CuboidsOptions& options, const ProgressOfImages& progress);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_CUBOIDS_H
