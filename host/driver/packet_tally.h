// What the headers of good packets say about those that never came.
#ifndef SELFPROJ_HOST_DRIVER_PACKET_TALLY_H
#define SELFPROJ_HOST_DRIVER_PACKET_TALLY_H

#include <array>
#include <cstddef>
#include <cstdint>

#include "host/driver/counters.h"
#include "model/packet.h"

namespace selfproj {

// Follows sequence, time stamp and `lost` of every stream and kind. What was lost or missing before the first packet is
// not known, and not counted; after a restart of the board everything since its reset is.
class PacketTally {
 public:
  // Counts lost_board, missing, repeated and restarts in `counters`, which must outlive it.
  explicit PacketTally(Counters& counters) : counters_(counters) {}

  // Takes note of a good packet, in the order in which they come. False where it is the one before once more (same
  // frame, same line or an earlier one): it is not to be handed out.
  bool accept(const PacketHeader& header);

  // Another writer takes over: its packets are no repetitions, whatever they say of themselves.
  void begin_anew();

 private:
  static constexpr std::size_t kStreams = 256;
  static constexpr std::size_t kKinds = 3;

  // The newest packet of a stream and kind.
  struct Newest {
    PacketHeader header = {};
    bool known = false;  // there is one
    bool reset = false;  // none since the board was reset
    bool anew = false;   // none of the new writer
  };

  Counters& counters_;
  std::array<std::array<Newest, kKinds>, kStreams> newest_{};
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_PACKET_TALLY_H
