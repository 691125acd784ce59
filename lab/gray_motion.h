// Experiment B2: how fast waves run on water.
#ifndef SELFPROJ_LAB_GRAY_MOTION_H
#define SELFPROJ_LAB_GRAY_MOTION_H

#include <string>

#include "lab/structured_light.h"
#include "sim/scene/scenes.h"

namespace selfproj::lab {

// Returns the tables of B2, and which pools do not reach the goal: the speed of long waves must be within 5 % of
// sqrt(g depth).
StructuredLightResult run_waves(const GrayMotionOptions& options, const ProgressOfImages& progress);

// Experiments B1 (a fist), B2 (waves) and B3 (fingers on keys): motion in depth images by Gray codes of 8 bits, with
// the median, after every pair of images.

// `name` is "B1", "B2" or "B3".
// B1: the frequency and the centroid of the fist on the path of the thesis, on which the filter's constants were
// chosen, and on drawn paths. Goals, for each drawn path: the frequency within 2 %; where at least half of the fist is
// in view, the centroid within 10 mm RMS, and none is missing. B2: the speed of long waves, from the frequencies of all
// standing waves in the pool. Also the speed of the foremost crest, and the speeds by wavelength. Other pools follow,
// without the speeds by wavelength. B3: the taps of the thesis, and a second set with other frequencies, strokes and
// phases. Goals: frequencies within 2 %, amplitudes within 10 %, z within kHalfPixelOnPlane RMS. Throws
// std::invalid_argument if `frames` is less than one cycle of the patterns.
StructuredLightResult run_gray_motion(const std::string& name, const GrayMotionOptions& options,
                                      const ProgressOfImages& progress);

// A path drawn by a seed, on which camera and projector see the fist all the way.
sim::FistPath drawn_path(std::uint64_t seed);

// A drop drawn by a seed: water 15 to 45 mm deep, another place, another crater.
sim::PoolDrop drawn_drop(std::uint64_t seed);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_GRAY_MOTION_H
