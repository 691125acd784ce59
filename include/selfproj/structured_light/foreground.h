// The foreground of a depth image: what differs from the depth image of the background.
#ifndef SELFPROJ_STRUCTURED_LIGHT_FOREGROUND_H
#define SELFPROJ_STRUCTURED_LIGHT_FOREGROUND_H

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

// The 0th and 1st moments of the points that differ: their number, and their centroid in mm (NaN if there are none).
struct Foreground {
  std::int64_t pixels = 0;
  double x = 0;
  double y = 0;
  double z = 0;
};

// Finds the pixels that have a depth in both images and differ by more than `min_mm` >= 0. The images have the size of
// the triangulation. Sums use 32-bit floats over at most 16 pixels and 64 bits beyond. Allocates nothing.
Foreground foreground_of(const Triangulation& triangulation, const float* z, const float* background, float min_mm);

// Further conditions for what counts as foreground. A code is collected over 2m frames. If the edge of a thing or of
// its shadow sweeps over a pixel meanwhile, some of its bits belong to one surface and some to the other, and its depth
// is that of neither. Such a depth does not stay from one depth image to the next, and it differs from its neighbours'.
struct SteadySettings {
  float max_change_mm = std::numeric_limits<float>::infinity();  // since the previous depth image; infinite: any
  int min_neighbours = 0;  // 0..8 neighbouring pixels of the foreground within that distance in z
};

// Keeps the foreground of each depth image in a sequence.
class SteadyFilter {
 public:
  // Allocates everything. Throws std::invalid_argument if a setting is out of range.
  SteadyFilter(int rows, int columns, const SteadySettings& settings);

  // Whether the settings ask for any filtering.
  [[nodiscard]] bool is_on() const { return on_; }

  // Finds the pixels of a depth image `z` that differ from the background by more than `min_mm` and are steady.
  void apply(const float* z, const float* background, float min_mm);

  // Makes `z` the previous depth image. Without a previous image all pixels are steady.
  void remember(const float* z);

  // The result: depth, NaN elsewhere, rows x columns.
  [[nodiscard]] const float* kept() const { return kept_.data(); }

 private:
  int rows_, columns_;
  SteadySettings settings_;
  bool on_;
  bool has_before_ = false;
  std::vector<float> before_;
  std::vector<float> steady_;  // with a margin of one NaN on each side
  std::vector<float> kept_;
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_STRUCTURED_LIGHT_FOREGROUND_H
