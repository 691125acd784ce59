// Saturation: an exposure that is too long for a bright part fills the pixels' wells.
#ifndef SELFPROJ_SIM_SCENE_SATURATION_H
#define SELFPROJ_SIM_SCENE_SATURATION_H

#include <span>

namespace selfproj {

struct Saturation {
  double exposure = 1;     // factor of all light
  double well_grey = 255;  // grey value at which a pixel's well is full
};

// min(dark + exposure (value - dark), well_grey), before the noise.
void saturate(const Saturation& saturation, double dark, std::span<float> pixels);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SATURATION_H
