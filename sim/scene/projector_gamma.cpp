#include "sim/scene/projector_gamma.h"

#include <algorithm>
#include <cmath>

#include "host/images/float_image.h"

namespace selfproj {

float light_through(const ProjectorGamma& gamma, float wanted) {
  constexpr double kFull = 255;
  const double level = std::round(kFull * std::pow(static_cast<double>(wanted), 1 / gamma.compensated)) / kFull;
  return static_cast<float>(std::pow(level, gamma.gamma));
}

FloatImage light_through(const ProjectorGamma& gamma, const FloatImage& wanted) {
  FloatImage light = wanted;
  std::transform(light.values.begin(), light.values.end(), light.values.begin(),
                 [&](float value) { return light_through(gamma, value); });
  return light;
}

}  // namespace selfproj
