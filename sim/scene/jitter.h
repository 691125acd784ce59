// Jitter: the camera is triggered a little early or late, and the encoder does not count where the belt truly is.
#ifndef SELFPROJ_SIM_SCENE_JITTER_H
#define SELFPROJ_SIM_SCENE_JITTER_H

#include <cstdint>

namespace selfproj {

struct Jitter {
  double trigger_us = 0;  // standard deviation of the time of a frame
  double encoder_mm = 0;  // standard deviation of the belt's place at it
};

// How much later than planned a frame of a belt with this speed (mm/s) is taken, s: normal, new in every frame. On a
// belt that stands still the encoder does not matter.
double lateness(const Jitter& jitter, std::uint64_t seed, int frame, double speed);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_JITTER_H
