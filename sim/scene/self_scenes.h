// The scenes of self-projected structured light on rig B. docs/simulation.md has their sizes.
#ifndef SELFPROJ_SIM_SCENE_SELF_SCENES_H
#define SELFPROJ_SIM_SCENE_SELF_SCENES_H

#include <array>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// B4: two cuboids on the plane. `marked` adds a letter carved into the low one and blocks on the high one. Sizes in mm.
struct Cuboids {
  struct Part {
    Box box;
    double height;  // height of its top over the plane
  };
  static constexpr double kLow = 25;
  static constexpr double kHigh = 109;
  static constexpr Part kLowPart{{-40, 90, -130, -30}, kLow};
  static constexpr Part kHighPart{{-10, 80, -10, 100}, kHigh};
  static constexpr std::array<double, 3> kBlockHeights{3, 6, 9};  // over the high cuboid
  static constexpr std::array<Box, 3> kBlocks{{{40, 60, 12, 32}, {40, 60, 40, 60}, {40, 60, 68, 88}}};
  static constexpr double kLetterDepth = 2;
  static constexpr double kLetterStroke = 10;  // width

  // Distance of a place from the centre lines of the letter A's strokes.
  static double distance_from_letter(double x, double y);
};

// B7: a slider 100 mm high along y; on it a plate 3 mm thick that carries a mouse along y.
struct MouseRun {
  static constexpr Box kSlider{-5, 65, -230, 230};
  static constexpr double kSliderHeight = 100;
  static constexpr double kPlateHeight = 103;  // height of its top over the plane: z = 447
  static constexpr double kSpeed = 300;        // mm/s
  static constexpr double kStart = -90;        // mm, y of its middle at t = 0
  static constexpr double kX = 30;             // x of its middle; its top there is within 16 codes of the slider
  static constexpr double kHeight = 26.5;      // height of the mouse
  static constexpr double kWidth = 38.5;       // along x
  static constexpr double kLength = 68.2;      // along y
};

// B8: a block 109 mm high under the left hand (y < 0), and the plane under the right hand. Both hands wave sideways
// three times a second, so that the left one stays over the block and in the light of the central 512 lines.
struct TwoHands {
  static constexpr Box kBlock{-30, 115, -150, -25};
  static constexpr double kBlockHeight = 109;
  static constexpr double kFrequency = 3;
};

// These scenes in the order of the list, without their numbers of frames.
const std::vector<SceneInfo>& self_scenes();

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SELF_SCENES_H
