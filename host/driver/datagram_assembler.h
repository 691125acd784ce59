// Puts packets together from datagrams that may be lost, doubled, reordered or cut.
#ifndef SELFPROJ_HOST_DRIVER_DATAGRAM_ASSEMBLER_H
#define SELFPROJ_HOST_DRIVER_DATAGRAM_ASSEMBLER_H

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/driver/counters.h"
#include "model/datagram.h"
#include "model/packet.h"

namespace selfproj {

// Gives whole packets in the order in which they were sent. A session is one run of the sender. A reader that comes
// late ignores the packet in whose middle it begins. Each later packet of the session is given once or counted: in
// `bad` if it is complete but wrong, otherwise in `lost_network`. Datagrams may overtake each other by up to kPackets
// packets.
//
//     for (each datagram) {
//       do {
//         while (assembler.next(packet)) { ... }
//       } while (!assembler.add(datagram));
//     }
//
// Allocates only in the constructor.
class DatagramAssembler {
 public:
  static constexpr std::size_t kPackets = 64;      // packets in assembly at a time
  static constexpr std::size_t kSequences = 1024;  // datagrams that are remembered

  // Counts in `counters`, which must outlive the assembler.
  explicit DatagramAssembler(Counters& counters);

  // Takes a whole datagram. Returns false if an older packet still has the place that the datagram needs. Then call
  // next() until it returns false, and add the datagram again.
  bool add(std::span<const std::uint8_t> datagram);

  // Returns the next packet, which stays valid until the next call. Returns false if none is complete.
  bool next(PacketView& packet);

  // Call when nothing has come for so long that no late datagram is expected. Incomplete packets then count as lost.
  void flush();

 private:
  // A packet in assembly.
  struct Slot {
    std::vector<std::uint8_t> bytes;
    std::size_t received = 0;
    bool begun = false;  // its first piece has come
  };

  void begin(const DatagramHeader& header);
  // Notes the number of a datagram. Returns false if it was noted before.
  bool note(std::uint32_t sequence);
  void store(const DatagramHeader& header, std::span<const std::uint8_t> piece);
  [[nodiscard]] bool complete(const Slot& slot) const;
  void give_up(std::uint32_t packets);
  Slot& slot(std::uint32_t packet) { return slots_[packet % kPackets]; }
  static void clear(Slot& slot);

  Counters& counters_;
  std::array<Slot, kPackets> slots_;
  std::bitset<kSequences> seen_;     // of the last kSequences datagrams, by sequence modulo kSequences
  std::uint32_t next_sequence_ = 0;  // the number after that of the newest datagram
  std::uint32_t next_packet_ = 0;    // the next packet to give
  std::uint32_t end_packet_ = 0;     // the number after that of the newest packet of which a piece has come
  std::uint32_t given_up_ = 0;       // packets before this one will not be completed any more
  std::uint32_t joined_ = 0;         // the packet in whose middle the reader began
  std::uint16_t session_ = 0;
  std::uint16_t old_session_ = 0;
  bool started_ = false;
  bool had_session_ = false;  // old_session_ has a meaning
  bool in_middle_ = false;    // joined_ has a meaning
  bool held_ = false;         // the user still reads the packet before next_packet_
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_DATAGRAM_ASSEMBLER_H
