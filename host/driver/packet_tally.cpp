#include "host/driver/packet_tally.h"

#include <cstddef>
#include <cstdint>

#include "model/packet.h"

namespace selfproj {

bool PacketTally::accept(const PacketHeader& header) {
  auto& stream = newest_[header.stream];
  Newest& kind = stream[static_cast<std::size_t>(header.kind - 1)];
  const PacketHeader& newest = kind.header;
  const bool moments = header.kind == spec::kKindMoments;
  const auto lost_since = static_cast<std::uint32_t>(header.lost - newest.lost);  // modulo 2^32
  constexpr std::uint32_t kBackwards = std::uint32_t{1} << 31U;

  if (kind.known) {
    const bool same_frame = header.same_frame(newest);
    const bool not_later = same_frame && (moments || header.first_line <= newest.first_line);
    if (not_later && !kind.anew) {
      ++counters_.repeated;
      return false;
    }
    // If a frame number comes with the wrong time, or anything runs backwards, the board was restarted.
    const bool restarted = not_later || header.sequence < newest.sequence || header.time_stamp < newest.time_stamp ||
                           (!same_frame && header.sequence == newest.sequence) || lost_since >= kBackwards;
    if (restarted) {
      ++counters_.restarts;
      stream.fill({.reset = true});
    } else {
      counters_.lost_board += lost_since;
      counters_.missing += moments ? header.sequence - newest.sequence - 1 : 0;
    }
  }
  if (kind.reset) {
    counters_.lost_board += header.lost;
    counters_.missing += moments ? header.sequence : 0;
  }
  kind = {.header = header, .known = true, .reset = false, .anew = false};
  return true;
}

void PacketTally::begin_anew() {
  for (auto& stream : newest_) {
    for (Newest& kind : stream) {
      kind.anew = true;
    }
  }
}

}  // namespace selfproj
