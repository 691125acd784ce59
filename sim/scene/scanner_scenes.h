// The scenes of rig B: a fist over things on a table, waves on a pool, fingers on keys. docs/simulation.md has their
// sizes.
#ifndef SELFPROJ_SIM_SCENE_SCANNER_SCENES_H
#define SELFPROJ_SIM_SCENE_SCANNER_SCENES_H

#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// The motion in the scenes, for those who measure it.
struct FistMotion {
  static constexpr double kFrequency = 3.5;  // turns a second
  static constexpr double kRadius = 60;      // mm
};
struct PoolWave {
  static constexpr double kImpact = 1.36;  // s
  static constexpr double kDepth = 30;     // mm
  static constexpr double kSpeed = 542.2;  // mm/s: sqrt(g depth)
  static constexpr double kLength = 340;   // along y
  static constexpr double kWidth = 250;    // along x
  static constexpr double kCentreX = -10;  // of the pool
  static constexpr double kImpactX = -10;  // where the body falls
  static constexpr double kImpactY = -60;
};
struct KeyTaps {
  static constexpr double kFrequency = 5;  // taps of each finger in a second
  static constexpr double kStroke = 10;    // mm, from top to bottom
  struct Pixel {
    int row, column;
  };
  static constexpr Pixel kFirst{220, 247};
  static constexpr Pixel kSecond{249, 224};
};

// These scenes in the order of the list, without their numbers of frames.
const std::vector<SceneInfo>& scanner_scenes();

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SCANNER_SCENES_H
