// How often the neighbourhood search (4.19, 4.20) is wrong, where the truth is known.
#ifndef SELFPROJ_SIM_EXPERIMENT_MATCH_SHARES_H
#define SELFPROJ_SIM_EXPERIMENT_MATCH_SHARES_H

#include <cstddef>

#include "host/io/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"

namespace selfproj {

// What is matched of the true codes of a scene: for every pixel on which the projector's light falls, whose true place
// lies within the window.
struct MatchShares {
  std::size_t pixels = 0;
  double wrong = 0;      // share of them whose match is another place: by more than half the cell and a line
  double none = 0;       // share without a match
  std::size_t far = 0;   // pixels 2^m cells or more from a step of the reference, in the camera's image
  double far_wrong = 0;  // share of those
};

// `true_z`, `reference_z`: of the scene and of its reference, mm, NaN where the projector's light does not fall.
// Shares are 0..1, NaN of no pixels.
MatchShares match_shares(const Rig& rig, const SelfReference& reference, const MatchSettings& settings,
                         const FloatImage& true_z, const FloatImage& reference_z);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_MATCH_SHARES_H
