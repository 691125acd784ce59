// selfproj-sim cosim with a scene of self-projected structured light: self-projected patterns through camera, board,
// driver and the matching block behind it to depth images.
#ifndef SELFPROJ_SIM_APP_COSIM_SELF_H
#define SELFPROJ_SIM_APP_COSIM_SELF_H

#include <string>

#include "sim/app/cosim_scanner.h"

namespace selfproj {

// Whether a scene is one of self-projected structured light.
bool is_self_scene(const std::string& scene);

// e of (4.20) with which the thesis measures it: 8 of the cuboids (B4), 0 of mouse and hands (B7, B8).
int self_scene_e(const std::string& scene);

// The scene's reference is scanned by Gray codes, and patterns and match table are made of it. Then frames of the scene
// go through the platform; what the board makes of them is compared with its model, and its code images, as the driver
// gives them, go through the matching block, whose lines are compared with model/gray_match and with the host's own for
// every pixel. Throws UserError, and CheckFailed where something differs.
void run_self_cosim(const ScannerCosimOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_COSIM_SELF_H
