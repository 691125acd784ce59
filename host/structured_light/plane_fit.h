// How flat a measured plane is: the flatness check of a scanner, on a depth image.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_PLANE_FIT_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_PLANE_FIT_H

#include <cstddef>
#include <limits>

#include "selfproj/images/float_image.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

// A part of the depth image.
struct PlaneRegion {
  int row = 0, column = 0;  // the first ones
  int rows = 0, columns = 0;
};

// The plane z = z0 + a x + b y nearest in z to the points that lie on it (least squares); lengths in mm.
struct PlaneFit {
  std::size_t points = 0;
  std::size_t left_out = 0;                              // points that do not lie on it
  double z0 = std::numeric_limits<double>::quiet_NaN();  // on the axis x = y = 0
  double a = std::numeric_limits<double>::quiet_NaN();
  double b = std::numeric_limits<double>::quiet_NaN();
  double rms = std::numeric_limits<double>::quiet_NaN();       // of the residuals in z
  double greatest = std::numeric_limits<double>::quiet_NaN();  // of their magnitudes
  // RMS of the error in z that rounding to whole codes alone would cause if it were independent from pixel to pixel:
  // (4.23) with Xp uniform over a code, at the same points.
  double rounding_rms = std::numeric_limits<double>::quiet_NaN();
};

// Fits the plane on which most pixels with a depth lie, of a region or of the whole image (RANSAC, with triples that
// are the same in each run). A point lies on it within four standard deviations of what rounding to codes does to it,
// or, where the plane is not quite flat, within 4.5 of the points' own, by their median. The result is NaN if fewer
// than 3 pixels have a depth or they lie on a line. Throws std::invalid_argument if the sizes differ or the region is
// not within the image.
PlaneFit fit_plane(const Triangulation& triangulation, const images::FloatImage& depth);
PlaneFit fit_plane(const Triangulation& triangulation, const images::FloatImage& depth, const PlaneRegion& region);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_PLANE_FIT_H
