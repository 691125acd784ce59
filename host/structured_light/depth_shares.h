// How many pixels of a depth image have a depth, and why the others have none.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_SHARES_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_SHARES_H

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/structured_light/triangulation.h"

namespace selfproj {

// The number of pixels in each state.
struct DepthShares {
  std::array<std::size_t, kPointStates> count{};

  [[nodiscard]] std::size_t of(PointState state) const { return count[static_cast<std::size_t>(state)]; }
  [[nodiscard]] std::size_t total() const;
};
DepthShares count_states(const std::vector<PointState>& states);

// The name used in summary.json: "valid", "not_measurable", ...
const char* name_of(PointState state);

// Text such as "44.37 % valid".
std::string share_text(const DepthShares& shares, PointState state);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_SHARES_H
