// Observes a moving scene with Gray codes of 8 bits, for B1 to B3. After every pair of images there is a depth image,
// together with the true depths.
#ifndef SELFPROJ_LAB_GRAY_OBSERVATION_H
#define SELFPROJ_LAB_GRAY_OBSERVATION_H

#include <cstddef>
#include <cstdint>
#include <functional>

#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/triangulation.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

inline constexpr int kGrayBits = 8;
inline constexpr int kGrayCycle = 2 * kGrayBits;  // frames

struct GrayMotionOptions {
  Rig rig;
  RenderOptions render;
  int paths = 10;               // B1: drawn paths of the fist, in addition to the one on which the filter is tuned
  int pools = 6;                // B2: pools in addition to that of the thesis: first 20 and 40 mm deep, then drawn ones
  std::uint64_t pool_seed = 0;  // B2: if more than 0, all of these pools are drawn, by this seed and the next ones
  // Frames of each path, pool or set of taps, an even number. 0 means one turn of the fist, until 0.55 s after the
  // impact, or five taps.
  int frames = 0;
};

// A depth image, and the true depths in the middle of its cycle.
struct Seen {
  double t;  // s
  const Triangulation& triangulation;
  const FloatImage& depth;
  const FloatImage& background;
  const FloatImage& truth;
  const FloatImage& true_background;  // NaN where the background has no depth
  // Depths at the borders between codes (CodeBorders). Those of the scene exist only after the last pair of a cycle,
  // and are null otherwise.
  const FloatImage* borders;
  const FloatImage& background_borders;
};

// What is observed: a scene over its background.
struct GrayShot {
  const Scene& scene;
  const Scene& background;
  int first = 0;   // frame
  int frames = 0;  // even
  std::int64_t noise_seed = 1;
  bool truth = true;  // if false, the true depths of the scene are not computed, and are NaN
};

// Calls `see` with each depth image of the scene, and `done` after each frame of the scene and of its background.
void observe(const GrayMotionOptions& options, const GrayShot& shot, const std::function<void()>& done,
             const std::function<void(const Seen&)>& see);

// Returns how many frames so many shots have, of which each has `frames` frames and one cycle of the background.
inline std::size_t images_of(int shots, int frames) { return static_cast<std::size_t>(shots * (kGrayCycle + frames)); }

}  // namespace selfproj

#endif  // SELFPROJ_LAB_GRAY_OBSERVATION_H
