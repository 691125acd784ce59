// The built-in scenes, how each is measured, and against what. docs/simulation.md has their sizes.
#ifndef SELFPROJ_SIM_SCENE_SCENES_H
#define SELFPROJ_SIM_SCENE_SCENES_H

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/scene.h"

namespace selfproj::sim {

// How a scene is measured.
enum class SceneMethod : std::uint8_t {
  light_section,   // a self-projected line
  gray_codes,      // Gray-code patterns, against a background
  self_projected,  // Gray-code patterns that are straight on the reference
};

// The motion that is followed through the depth images of a gray_codes scene.
enum class SceneAnalysis : std::uint8_t {
  moved_centroid,  // the centroid of the pixels that differ from the background
  wave_front,      // the foremost crest of a ring wave
  key_taps,        // the depth at two pixels
};

struct SceneInfo {
  std::string name;
  std::string description;
  SceneMethod method = SceneMethod::light_section;
  std::string reference = {};  // the scene that is the good part or the background; empty if it is its own
  SceneAnalysis analysis = SceneAnalysis::moved_centroid;
  int cells_below = 0;  // e of (4.20) with which the thesis measures it; for self_projected
  std::unique_ptr<Scene> (*make)(const rig::Rig& rig) = nullptr;
  int frames = 0;  // number of frames with its own rig

  // The built-in rig for which it was made.
  [[nodiscard]] const char* rig() const { return method == SceneMethod::light_section ? "light-section" : "scanner"; }
  [[nodiscard]] const std::string& reference_name() const { return reference.empty() ? name : reference; }
};

// All built-in scenes; those of the light section come first.
const std::vector<SceneInfo>& scenes();

// The entry of a scene. Throws UserError for an unknown name.
const SceneInfo& find_scene(const std::string& name);

// Makes a scene by its name; it moves as the rig's conveyor does. Throws UserError for an unknown name, or for a scene
// that such a rig cannot measure.
std::unique_ptr<Scene> make_scene(const std::string& name, const rig::Rig& rig);

// The parts of the list, without numbers of frames: rig A, parts on a conveyor under a projected line; rig B under Gray
// codes; rig B under self-projected codes.
const std::vector<SceneInfo>& light_section_scenes();
const std::vector<SceneInfo>& scanner_scenes();
const std::vector<SceneInfo>& self_projected_scenes();

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
    [[nodiscard]] Pixel of(const rig::RigCamera& camera) const {
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

// The scene `fist` on a path.
std::unique_ptr<Scene> make_fist(const rig::Rig& rig, const FistPath& path);

// Water in the pool, and what falls into it. Lengths in mm.
struct PoolDrop {
  double depth = PoolWave::kDepth;  // of the water
  double x = PoolWave::kImpactX, y = PoolWave::kImpactY;
  // The crater of RingWave: its depth, and s, which is the radius of a circle as large as the body's side of 27 x 23.
  double crater = 14;
  double size = 14;
  double after = 0.4;  // s from the impact to the last frame; mirror images are right up to 0.8 s
};

// The scenes `pool` and `waves` with other water.
std::unique_ptr<Scene> make_pool(const rig::Rig& rig, double depth);
std::unique_ptr<Scene> make_waves(const rig::Rig& rig, const PoolDrop& drop);

// How the two fingers tap.
struct Taps {
  std::array<double, 2> frequency{KeyTaps::kFrequency, KeyTaps::kFrequency};  // taps a second
  std::array<double, 2> stroke{KeyTaps::kStroke, KeyTaps::kStroke};           // mm, from top to bottom
  std::array<double, 2> phase{0, std::numbers::pi};                           // rad; 0: down at t = 0
};

// The scene `keys` with other taps.
std::unique_ptr<Scene> make_keys(const rig::Rig& rig, const Taps& taps);

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

// The marks ○ × ▽ carved on the stairs of experiment A2: strokes of constant width around a centre line.
enum class Mark : std::uint8_t { circle, cross, triangle_down };

constexpr double kMarkSize = 22;   // mm, across and along
constexpr double kMarkStroke = 3;  // mm
constexpr double kMarkDepth = 1;   // mm

// Distance in mm of a point from the centre line of the mark's strokes; right and down are those of the mark, from its
// middle. The point is carved if the distance is at most kMarkStroke / 2. The distance changes by no more than the
// point moves.
inline double distance_from_mark(Mark mark, double right, double down) {
  constexpr double kReach = (kMarkSize - kMarkStroke) / 2;  // reach of the centre lines
  const auto segment = [&](double r0, double d0, double r1, double d1) {
    const double vr = r1 - r0;
    const double vd = d1 - d0;
    const double s = std::clamp(((right - r0) * vr + (down - d0) * vd) / (vr * vr + vd * vd), 0.0, 1.0);
    const double r = right - r0 - s * vr;
    const double d = down - d0 - s * vd;
    return std::sqrt(r * r + d * d);
  };
  switch (mark) {
    case Mark::circle:
      return std::abs(std::sqrt(right * right + down * down) - kReach);
    case Mark::cross:
      return std::min(segment(-kReach, -kReach, kReach, kReach), segment(-kReach, kReach, kReach, -kReach));
    case Mark::triangle_down:
      break;
  }
  return std::min({segment(-kReach, -kReach, kReach, -kReach), segment(kReach, -kReach, 0, kReach),
                   segment(0, kReach, -kReach, -kReach)});
}

// A part from a map of its heights above the plane, mm. The map is oriented like the measured heights: its first row
// reaches the line first (largest x), y grows with the column, and its middle is at y = 0. A pixel is a square with
// sides of mm_per_pixel and its height at its centre; between the centres heights are interpolated linearly. The map
// ends in vertical faces. NaN stands for the bare plane. Throws UserError about `source` if there are no pixels, the
// scale is not positive, or heights are not below the camera and the projector.
std::unique_ptr<Scene> height_map_scene(const images::FloatImage& height_mm, double mm_per_pixel, const rig::Rig& rig,
                                        const std::string& source = "height map");

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_SCENES_H
