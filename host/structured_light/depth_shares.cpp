#include "host/structured_light/depth_shares.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

namespace selfproj {
namespace {

constexpr std::array<const char*, kPointStates> kNames{"valid",      "not_measurable", "no_line", "no_intersection",
                                                       "too_coarse", "out_of_range",   "off_line"};

}  // namespace

std::size_t DepthShares::total() const { return std::accumulate(count.begin(), count.end(), std::size_t{0}); }

DepthShares count_states(const std::vector<PointState>& states) {
  DepthShares shares;
  for (const PointState state : states) {
    ++shares.count[static_cast<std::size_t>(state)];
  }
  return shares;
}

const char* name_of(PointState state) { return kNames[static_cast<std::size_t>(state)]; }

std::string share_text(const DepthShares& shares, PointState state) {
  return fmt::format("{:.2f} % {}", 100.0 * static_cast<double>(shares.of(state)) / static_cast<double>(shares.total()),
                     name_of(state));
}

}  // namespace selfproj
