// The scenes of rig B: a fist over things on a table, waves on a pool, fingers on keys. docs/simulation.md has their
// sizes.
#ifndef SELFPROJ_SIM_SCENE_SCANNER_SCENES_H
#define SELFPROJ_SIM_SCENE_SCANNER_SCENES_H

#include <array>
#include <cstdint>
#include <memory>
#include <numbers>
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
  static constexpr double kSpeed = 542.2;  // mm/s: sqrt(g depth), of long waves
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
    // The same place of the image of a camera of other than 512 x 512 pixels.
    [[nodiscard]] Pixel of(const RigCamera& camera) const {
      return {row * camera.rows / 512, column * camera.columns / 512};
    }
  };
  static constexpr Pixel kFirst{220, 247};
  static constexpr Pixel kSecond{249, 224};
};

// The fist's path: a circle whose plane rises along the direction `towards`. Lengths in mm, angles in rad.
struct FistPath {
  double x = 60, y = 0, height = 130;  // of its middle, over the plane
  double radius = FistMotion::kRadius;
  double rise = 50;                           // from the middle to the top, at most the radius
  double towards = 0;                         // from x towards y
  double frequency = FistMotion::kFrequency;  // turns a second
  double phase = 0;                           // at t = 0
};

// A path drawn by a seed, on which camera and projector see the fist all the way.
FistPath drawn_path(std::uint64_t seed);

// The scene `fist` on a path.
std::unique_ptr<Scene> make_fist(const Rig& rig, const FistPath& path);

// Water in the pool, and what falls into it. Lengths in mm.
struct PoolDrop {
  double depth = PoolWave::kDepth;  // of the water
  double x = PoolWave::kImpactX, y = PoolWave::kImpactY;
  // The crater of RingWave: its depth, and s, which is the radius of a circle as large as the body's side of 27 x 23.
  double crater = 14;
  double size = 14;
  double after = 0.4;  // s from the impact to the last frame; mirror images are right up to 0.8 s
};

// A drop drawn by a seed: water 15 to 45 mm deep, another place, another crater.
PoolDrop drawn_drop(std::uint64_t seed);

// The scenes `pool` and `waves` with other water.
std::unique_ptr<Scene> make_pool(const Rig& rig, double depth);
std::unique_ptr<Scene> make_waves(const Rig& rig, const PoolDrop& drop);

// How the two fingers tap.
struct Taps {
  std::array<double, 2> frequency{KeyTaps::kFrequency, KeyTaps::kFrequency};  // taps a second
  std::array<double, 2> stroke{KeyTaps::kStroke, KeyTaps::kStroke};           // mm, from top to bottom
  std::array<double, 2> phase{0, std::numbers::pi};                           // rad; 0: down at t = 0
};

// The scene `keys` with other taps.
std::unique_ptr<Scene> make_keys(const Rig& rig, const Taps& taps);

// These scenes in the order of the list, without their numbers of frames.
const std::vector<SceneInfo>& scanner_scenes();

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SCANNER_SCENES_H
