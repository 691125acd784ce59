// How true heights differ from those of the geometry, as `selfproj calibrate heights` finds it.
#ifndef SELFPROJ_HOST_RIG_HEIGHT_CORRECTION_H
#define SELFPROJ_HOST_RIG_HEIGHT_CORRECTION_H

#include <array>
#include <vector>

#include "host/rig/height_terms.h"
#include "host/rig/rig.h"

namespace selfproj {

// A polynomial of column, row and height, each scaled to -1..1 over the image and over the calibrated heights. Its
// terms are products of Chebyshev polynomials.
class HeightCorrection {
 public:
  // Places outside the image are corrected as those at its border.
  HeightCorrection(const RigCamera& camera, const RigHeights& heights);

  // The values of all terms at an image place (from 0) and a height by the geometry.
  void terms(double row, double column, double height_mm, std::vector<double>& values) const;

  // What must be added to the height by the geometry; NaN for a height that is outside of the calibrated range by more
  // than a quarter of it.
  [[nodiscard]] double at(double row, double column, double height_mm) const;

 private:
  RigHeights heights_;
  double row_middle_, row_half_, column_middle_, column_half_;
  std::vector<std::array<int, 3>> degrees_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_HEIGHT_CORRECTION_H
