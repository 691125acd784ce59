#include "host/driver/packet_tally.h"

#include <cstddef>
#include <cstdint>

#include "model/packet.h"

namespace selfproj {

bool PacketTally::accept(const PacketHeader& header) {
  auto& stream = newest_[header.stream];
  Newest& newest = stream[static_cast<std::size_t>(header.kind - 1)];
  const bool moments = header.kind == spec::kKindMoments;
  const auto lost_since = static_cast<std::uint32_t>(header.lost - newest.lost);  // modulo 2^32
  constexpr std::uint32_t kBackwards = std::uint32_t{1} << 31U;

  if (newest.known) {
    const bool same_frame = header.sequence == newest.sequence && header.time_stamp == newest.time_stamp;
    if (same_frame && (moments || header.first_line <= newest.first_line)) {
      ++counters_.repeated;
      return false;
    }
    // A frame number without its own time, or anything that runs backwards, is another life of the board.
    const bool restarted = header.sequence < newest.sequence || header.time_stamp < newest.time_stamp ||
                           (!same_frame && header.sequence == newest.sequence) || lost_since >= kBackwards;
    if (restarted) {
      ++counters_.restarts;
      for (Newest& kind : stream) {
        kind = {.reset = true};
      }
    } else {
      counters_.lost_board += lost_since;
      counters_.missing += moments ? header.sequence - newest.sequence - 1 : 0;
    }
  }
  if (newest.reset) {
    counters_.lost_board += header.lost;
    counters_.missing += moments ? header.sequence : 0;
  }
  newest = {header.sequence, header.time_stamp, header.lost, header.first_line, true, false};
  return true;
}

}  // namespace selfproj
