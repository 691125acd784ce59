// How often the neighbourhood search (4.19, 4.20) is wrong, measured against the truth.
#ifndef SELFPROJ_LAB_MATCH_SHARES_H
#define SELFPROJ_LAB_MATCH_SHARES_H

#include <cstddef>

#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"

namespace selfproj {

// The matches of a scene's true codes, over all pixels that the projector lights and whose true place is in the window.
struct MatchShares {
  std::size_t pixels = 0;
  double wrong = 0;      // share whose match is off by more than half the cell and one line
  double none = 0;       // share without a match
  std::size_t far = 0;   // pixels 2^m cells or more from a step of the reference, in the camera's image
  double far_wrong = 0;  // share of those with a wrong match
};

// `true_z` and `reference_z` are the depths of the scene and of its reference, mm, NaN outside the projector's light.
// Shares are 0..1, NaN if there are no pixels.
MatchShares match_shares(const Rig& rig, const SelfReference& reference, const MatchSettings& settings,
                         const FloatImage& true_z, const FloatImage& reference_z);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_MATCH_SHARES_H
