// The parameter of the bounce of light (bounce.h).
#ifndef SELFPROJ_SIM_SCENE_BOUNCE_STRENGTH_H
#define SELFPROJ_SIM_SCENE_BOUNCE_STRENGTH_H

namespace selfproj {

struct Bounce {
  double strength = 1;  // 1: what evenly scattering faces throw
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BOUNCE_STRENGTH_H
