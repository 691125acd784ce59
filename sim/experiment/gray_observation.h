// A moving scene in depth images by Gray codes of 8 bits, after every pair of images, beside the truth: B1 to B3.
#ifndef SELFPROJ_SIM_EXPERIMENT_GRAY_OBSERVATION_H
#define SELFPROJ_SIM_EXPERIMENT_GRAY_OBSERVATION_H

#include <cstddef>
#include <cstdint>
#include <functional>

#include "host/io/float_image.h"
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
  int paths = 10;  // B1: drawn paths of the fist, each with noise of its own, beside that on which the filter is tuned
  int pools = 6;   // B2: pools of other depths, of 20 and 40 mm first, then drawn ones
  std::uint64_t pool_seed = 0;  // B2: if more than 0, all of these pools are drawn, by this seed and the next ones
  int frames = 0;  // even; of each path, pool or set of taps; 0: a turn, until 0.55 s after the impact, five taps
};

// A depth image and its truth, in the middle of its cycle.
struct Seen {
  double t;  // s
  const Triangulation& triangulation;
  const FloatImage& depth;
  const FloatImage& background;
  const FloatImage& truth;
  const FloatImage& true_background;  // NaN where the background has no depth
  // Depths at the borders between codes (CodeBorders), from the images of one cycle: after its last pair, else null;
  // and those of the background.
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
  bool truth = true;  // false: the true depths are left out, and NaN
};

// Calls `see` with each depth image of the scene, and `done` after each image of it and of its background.
void observe(const GrayMotionOptions& options, const GrayShot& shot, const std::function<void()>& done,
             const std::function<void(const Seen&)>& see);

// The number of images of so many shots of `frames` frames.
inline std::size_t images_of(int shots, int frames) { return static_cast<std::size_t>(shots * (kGrayCycle + frames)); }

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_GRAY_OBSERVATION_H
