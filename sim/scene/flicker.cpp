#include "sim/scene/flicker.h"

#include <cmath>
#include <numbers>

namespace selfproj {

double flicker_grey(const Flicker& flicker, double t, double exposure_s) {
  const double half = std::numbers::pi * flicker.hz * exposure_s;
  const double mean = half > 0 ? std::sin(half) / half : 1;
  return flicker.grey * (1 + flicker.modulation * mean * std::sin(2 * std::numbers::pi * flicker.hz * t));
}

}  // namespace selfproj
