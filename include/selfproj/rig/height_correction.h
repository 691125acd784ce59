// The difference between true heights and those that the geometry gives, as `selfproj calibrate heights` finds it.
#ifndef SELFPROJ_RIG_HEIGHT_CORRECTION_H
#define SELFPROJ_RIG_HEIGHT_CORRECTION_H

#include <array>
#include <vector>

#include "selfproj/rig/rig.h"

namespace selfproj::rig {

// A polynomial of column, row and height, each scaled to -1..1 over the image and over the calibrated heights. Its
// terms are products of Chebyshev polynomials.
class HeightCorrection {
 public:
  // Places outside the image get the correction of the nearest place at its border.
  HeightCorrection(const RigCamera& camera, const RigHeights& heights);

  // Writes the values of all terms at a row and column (from 0) and a height that the geometry gives.
  void terms(double row, double column, double height_mm, std::vector<double>& values) const;

  // Returns what must be added to the height that the geometry gives, or NaN if this height is outside the calibrated
  // range by more than a quarter of that range.
  [[nodiscard]] double at(double row, double column, double height_mm) const;

 private:
  RigHeights heights_;
  double row_middle_, row_half_, column_middle_, column_half_;
  std::vector<std::array<int, 3>> degrees_;
};

}  // namespace selfproj::rig

#endif  // SELFPROJ_RIG_HEIGHT_CORRECTION_H
