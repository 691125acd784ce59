// What moved: the depth image against the background's (section 7 of the method).
#ifndef SELFPROJ_HOST_GRAY_MOVED_H
#define SELFPROJ_HOST_GRAY_MOVED_H

#include <cstdint>

#include "host/gray/triangulation.h"

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

}  // namespace selfproj

#endif  // SELFPROJ_HOST_GRAY_MOVED_H
