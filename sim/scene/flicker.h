// Ambient light of lamps on alternating current, which flickers at twice the mains' frequency.
#ifndef SELFPROJ_SIM_SCENE_FLICKER_H
#define SELFPROJ_SIM_SCENE_FLICKER_H

namespace selfproj {

struct Flicker {
  double grey = 0;        // mean grey value that the lamps add
  double modulation = 0;  // (most - least) / (most + least) of their light, 0..1
  double hz = 100;
};

// The grey value that the lamps add to a frame whose exposure is centred on t: the mean over the exposure of
// grey (1 + modulation sin(2π hz t)), so that long exposures see less of it (sinc).
double flicker_grey(const Flicker& flicker, double t, double exposure_s);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_FLICKER_H
