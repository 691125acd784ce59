// Counts missing packets from the headers of good ones.
#ifndef SELFPROJ_HOST_DRIVER_PACKET_TALLY_H
#define SELFPROJ_HOST_DRIVER_PACKET_TALLY_H

#include <array>
#include <cstddef>
#include <cstdint>

#include "host/driver/counters.h"
#include "model/packet.h"

namespace selfproj {

// Follows sequence, time stamp and `lost` of every stream and kind. Losses before the first packet are not known and
// not counted. After a restart of the board all losses since its reset count.
class PacketTally {
 public:
  // Counts lost_board, missing, repeated and restarts in `counters`, which must outlive it.
  explicit PacketTally(Counters& counters) : counters_(counters) {}

  // Notes a good packet, in the order in which packets come. Returns false if it repeats the previous packet (same
  // frame, same line or an earlier one); it must not be given out then.
  bool accept(const PacketHeader& header);

  // Call when another writer takes over: its packets do not count as repetitions.
  void begin_anew();

 private:
  static constexpr std::size_t kStreams = 256;
  static constexpr std::size_t kKinds = 3;

  // The newest packet of a stream and kind.
  struct Newest {
    PacketHeader header = {};
    bool known = false;  // a packet has come
    bool reset = false;  // no packet since the board was reset
    bool anew = false;   // no packet of the new writer
  };

  Counters& counters_;
  std::array<std::array<Newest, kKinds>, kStreams> newest_{};
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_PACKET_TALLY_H
