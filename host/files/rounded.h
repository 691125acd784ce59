#ifndef SELFPROJ_HOST_FILES_ROUNDED_H
#define SELFPROJ_HOST_FILES_ROUNDED_H

#include <cmath>

namespace selfproj {

// Returns the multiple of 10^-decimals that is nearest to `value`, as a text of so many decimals would be read: 0.0003,
// not 0.00030000000000000003. `decimals` is 0..15; NaN and infinities stay.
inline double rounded(double value, int decimals) {
  const double units = std::pow(10.0, decimals);
  return std::round(value * units) / units;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_FILES_ROUNDED_H
