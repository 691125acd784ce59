// How many pixels of a depth image have a depth, and why the others have none.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_SHARES_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_SHARES_H

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/structured_light/triangulation.h"

namespace selfproj {

// Number of pixels of each state.
struct DepthShares {
  std::array<std::size_t, kPointStates> count{};

  [[nodiscard]] std::size_t of(PointState state) const { return count[static_cast<std::size_t>(state)]; }
  [[nodiscard]] std::size_t total() const;
};
DepthShares count_states(const std::vector<PointState>& states);

// "valid", "not_measurable", ...: as in summary.json.
const char* name_of(PointState state);

// "44.37 % valid".
std::string share_text(const DepthShares& shares, PointState state);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_SHARES_H
