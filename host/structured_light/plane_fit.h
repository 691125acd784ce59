// How flat a measured plane is: the flatness check of a scanner, on a depth image.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_PLANE_FIT_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_PLANE_FIT_H

#include <cstddef>
#include <limits>

#include "host/io/float_image.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

// The plane z = z0 + a x + b y nearest to the points in z (least squares); lengths in mm.
struct PlaneFit {
  std::size_t points = 0;
  double z0 = std::numeric_limits<double>::quiet_NaN();  // on the axis x = y = 0
  double a = std::numeric_limits<double>::quiet_NaN();
  double b = std::numeric_limits<double>::quiet_NaN();
  double rms = std::numeric_limits<double>::quiet_NaN();       // of the residuals in z
  double greatest = std::numeric_limits<double>::quiet_NaN();  // of their magnitudes
  // RMS of the error in z that rounding to whole codes alone would cause if it were independent from pixel to pixel:
  // (4.23) with Xp uniform over a code, at the same points.
  double rounding_rms = std::numeric_limits<double>::quiet_NaN();
};

// Fits all pixels of the triangulation that have a depth. The result is NaN if fewer than 3 have one or they lie on a
// line. Throws std::invalid_argument if the sizes differ.
PlaneFit fit_plane(const Triangulation& triangulation, const FloatImage& depth);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_PLANE_FIT_H
