// Puts packets together from datagrams that may be lost, doubled, reordered or cut.
#ifndef SELFPROJ_HOST_DRIVER_DATAGRAM_ASSEMBLER_H
#define SELFPROJ_HOST_DRIVER_DATAGRAM_ASSEMBLER_H

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/datagram.h"
#include "selfproj/driver/counters.h"
#include "selfproj/model/packet.h"

namespace selfproj::driver {

// Gives whole packets in the order in which they were sent. A session is one run of the sender. A reader that comes
// late ignores the packet in whose middle it begins. Each later packet of the session, up to the last of which anything
// came, is given once or counted: in `bad` if it is complete but wrong, otherwise in `lost_network`. Datagrams may
// overtake each other by fewer than kPackets packets. Their numbers wrap at 2^32; a session may have any number of
// packets, and an interruption may take 2^31 datagrams.
//
// A datagram whose numbers do not follow those before it (another session, or further away than datagrams overtake each
// other) is held back. kConfirmations of them, each following the one before and none of the stream between them, are
// the stream from then on: the sender was restarted, or the network was interrupted. Fewer are refused. So one false
// datagram changes nothing, and a receiver that was misled returns to the stream that goes on.
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
  static constexpr int kConfirmations = 3;         // datagrams that make a new stream
  // As many make a stream that goes back: that of a sender which was restarted and has drawn the same session.
  static constexpr int kConfirmationsBack = 64;
  // A later session begins with its first datagram, and what is missing there was lost, unless it is older than this.
  static constexpr std::uint32_t kYoung = std::uint32_t{1} << 20U;

  // Counts in `counters`, which must outlive the assembler.
  explicit DatagramAssembler(Counters& counters);

  // Takes a whole datagram. Returns false if an older packet still has the place that the datagram needs. Then call
  // next() until it returns false, and add the datagram again.
  bool add(std::span<const std::uint8_t> datagram);

  // Returns the next packet, which stays valid until the next call. Returns false if none is complete.
  bool next(model::PacketView& packet);

  // Call when nothing has come for so long that no late datagram is expected. Incomplete packets then count as lost.
  void flush();

 private:
  // A packet in assembly.
  struct Slot {
    std::vector<std::uint8_t> bytes;
    std::size_t received = 0;
    bool begun = false;  // its first piece has come
  };

  // How far a stream has come. The numbers go on where those of the datagrams wrap.
  struct Position {
    std::uint64_t sequence = 0;
    std::uint64_t packet = 0;
  };

  // Datagrams that do not follow those of the stream but each other.
  struct Candidate {
    std::array<std::vector<std::uint8_t>, kConfirmations> datagrams;  // the first of them
    model::DatagramHeader first = {};
    model::DatagramHeader last = {};
    int count = 0;
  };

  // Where an earlier session was.
  struct Session {
    Position position;
    std::uint16_t number = 0;
  };

  // What a candidate would be.
  enum class Change {
    goes_on,           // the stream, after an interruption
    goes_back,         // the stream, which has not been interrupted: the datagrams after before_gap_ were false
    false_start,       // a first stream: what came before it was too little to be one
    resumes,           // an earlier session
    restarts,          // a new session
    restarts_as_known  // a new session with the number of an earlier one, or datagrams that come very late
  };

  [[nodiscard]] bool follows(const model::DatagramHeader& header) const;
  [[nodiscard]] Change change_to(const model::DatagramHeader& first) const;
  [[nodiscard]] const Session* earlier(std::uint16_t session) const;
  bool add_to_stream(const model::DatagramHeader& header, std::span<const std::uint8_t> datagram);
  bool add_to_candidate(const model::DatagramHeader& header, std::span<const std::uint8_t> datagram);
  void refuse_candidate();
  void change_stream(Change change);
  void begin(const model::DatagramHeader& header);
  void restart(const model::DatagramHeader& first);
  void go_on(const Position& from, const model::DatagramHeader& first);
  void go_to(const Position& position);
  void count_gap();
  // Notes the number of a datagram. Returns false if it was noted before.
  bool note(std::uint64_t sequence);
  void store(const model::DatagramHeader& header, std::uint64_t packet, std::span<const std::uint8_t> piece);
  [[nodiscard]] bool complete(const Slot& slot) const;
  Slot& slot(std::uint64_t packet) { return slots_[packet % kPackets]; }
  static void clear(Slot& slot);

  Counters& counters_;
  std::array<Slot, kPackets> slots_;
  std::bitset<kSequences> seen_;     // of the last kSequences datagrams, by sequence modulo kSequences
  std::uint64_t next_sequence_ = 0;  // the number after that of the newest datagram
  std::uint64_t next_packet_ = 0;    // the next packet to give
  std::uint64_t end_packet_ = 0;     // the number after that of the newest packet of which a piece has come
  std::uint64_t given_up_ = 0;       // packets before this one will not be completed any more; at most end_packet_
  std::uint64_t joined_ = 0;         // the packet in whose middle the reader began
  std::uint64_t accepted_ = 0;       // datagrams of the stream since it began or went on at another number
  Candidate candidate_;
  std::size_t replayed_ = 0;  // of the datagrams of a candidate that has become the stream, those added to it
  std::size_t to_replay_ = 0;
  Position before_gap_;  // where the stream was before it went on at another number; while gap_open_
  Position gap_;         // how much is missing since then; not counted before it is clear that it does not go back
  std::array<Session, 4> earlier_{};
  std::size_t sessions_ = 0;  // sessions that were put into earlier_
  std::uint16_t session_ = 0;
  bool started_ = false;
  bool gap_open_ = false;
  bool in_middle_ = false;  // joined_ has a meaning
  bool held_ = false;       // the user still reads the packet before next_packet_
};

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_DATAGRAM_ASSEMBLER_H
