// What moved: the depth image against the background's (section 7 of the method).
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_MOVED_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_MOVED_H

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "host/structured_light/triangulation.h"

namespace selfproj {

// From the 0th and 1st moments of the points that differ: how many they are, and their centroid in mm (NaN where there
// are none).
struct Moved {
  std::int64_t pixels = 0;
  double x = 0;
  double y = 0;
  double z = 0;
};

// The pixels that have a depth in both images, of as many pixels as the triangulation's, and differ there by more than
// `least_mm` >= 0. Sums are taken in 32-bit floats over 16 pixels at most and in 64 bits beyond. Allocates nothing.
Moved moved(const Triangulation& triangulation, const float* z, const float* background, float least_mm);

// What counts as moved besides that. A code is put together over 2m frames: where the edge of a thing or of its shadow
// has swept over a pixel meanwhile, some of its bits are of one surface and some of the other, and its depth is that of
// neither. Such a depth does not stay from one depth image to the next, and its neighbours' are others.
struct SteadySettings {
  float most_change_mm = std::numeric_limits<float>::infinity();  // from the depth image before; infinite: any
  int least_neighbours = 0;  // 0..8 of the pixels around, moved and not further away in z than that
};

// Leaves of one depth image after another what moved.
class SteadyFilter {
 public:
  // Everything is allocated here. Throws std::invalid_argument where a setting is out of range.
  SteadyFilter(int rows, int columns, const SteadySettings& settings);

  // Whether the settings ask for anything.
  [[nodiscard]] bool is_on() const { return on_; }

  // Finds the pixels of a depth image `z` that differ from the background by more than `least_mm` and stay.
  void take(const float* z, const float* background, float least_mm);

  // Makes `z` the depth image before. Until there is one, all stay.
  void remember(const float* z);

  // What was found: depth, NaN elsewhere, rows x columns.
  [[nodiscard]] const float* kept() const { return kept_.data(); }

 private:
  int rows_, columns_;
  SteadySettings settings_;
  bool on_;
  bool has_before_ = false;
  std::vector<float> before_;
  std::vector<float> steady_;  // with a margin of NaN of a pixel all round
  std::vector<float> kept_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_MOVED_H
