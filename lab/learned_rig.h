// What a user learns about a light section from images alone: the rig, by a chessboard and plates on its belt, and the
// shape of the good part, by a scan. Nothing here knows the rig that takes the images, but for the simulated camera.
#ifndef SELFPROJ_LAB_LEARNED_RIG_H
#define SELFPROJ_LAB_LEARNED_RIG_H

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/rig/rig.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj::lab {

// What is captured for it. The targets have flaws of their own, drawn by `seed` within the tolerances that `selfproj
// calibrate` assumes.
struct LearningSettings {
  std::vector<double> board_heights_mm{0, 16, 32, 48};          // of the plate that carries the chessboard
  std::vector<double> belt_mm{0, 6};                            // places of the belt for each of them
  std::vector<double> plate_heights_mm{0, 12, 24, 36, 48, 60};  // of the plain plates under the lines
  int every_line = 8;                                           // step of the sweeps, in projector lines
  std::uint64_t seed = 1;
};

struct LearnedRig {
  rig::Rig rig;           // as the host has it from now on
  double checked_mm = 0;  // greatest error of a further plate, kCheckedPlate high, that took no part
};
inline constexpr double kCheckedPlate = 15;  // mm

// The number of images that learn_rig takes of a rig with such a projector.
int learning_images(const rig::Rig& drawn, const LearningSettings& settings);

// Learns the rig `actual` from its images, starting from its drawings `actual.rig`: lenses, poses and belt by
// `selfproj calibrate --plates --moves`, heights by `selfproj calibrate heights`. `options` describe the camera;
// targets are matt and evenly white. `done` is called after each image. Throws CheckFailed if the images do not
// determine the rig, and UserError if camera or projector do not see a target.
LearnedRig learn_rig(const sim::PerturbedRig& actual, const sim::RenderOptions& options,
                     const LearningSettings& settings, const std::function<void()>& done);

struct ScanSettings {
  sim::RenderOptions render;
  int every_line = 8;    // step of the sweep
  bool residual = true;  // the part passes under its pattern, and the residual is taken out
};

// The number of images that scanned_projection takes of the sweep.
int scanning_images(const rig::Rig& rig, int every_line);

// Self-projection onto a good part that was scanned: a sweep over the part, which stands still in the middle of its
// way, gives the pattern and the reference of each mode (LineScan). `reference` makes the part's scene on a rig's belt.
// `done` is called after each image of the sweep.
using MakeScene = std::function<std::unique_ptr<sim::Scene>(const rig::Rig&)>;
sim::LightSection scanned_projection(const rig::Rig& learned, const sim::PerturbedRig& actual,
                                     const MakeScene& reference, const ScanSettings& settings,
                                     const std::function<void()>& done);

// The same for a built-in scene by its name.
sim::LightSection scanned_projection(const rig::Rig& learned, const sim::PerturbedRig& actual,
                                     const std::string& reference, const ScanSettings& settings,
                                     const std::function<void()>& done);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_LEARNED_RIG_H
