// The projector's gamma: its light is a power of the 8-bit level that it is sent.
#ifndef SELFPROJ_SIM_SCENE_PROJECTOR_GAMMA_H
#define SELFPROJ_SIM_SCENE_PROJECTOR_GAMMA_H

#include "host/images/float_image.h"

namespace selfproj {

struct ProjectorGamma {
  double gamma = 1;        // of the projector
  double compensated = 1;  // the gamma that the sender of the patterns believes in; 1: it sends the light as it is
};

// The light 0..1 that comes out where `wanted` 0..1 was meant: round(255 wanted^(1/compensated))/255 to the power of
// gamma.
float light_through(const ProjectorGamma& gamma, float wanted);

// The same for a pattern.
FloatImage light_through(const ProjectorGamma& gamma, const FloatImage& wanted);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PROJECTOR_GAMMA_H
