// Compares the packets of a board with those of the model of the board: every byte, and every loss.
#ifndef SELFPROJ_SIM_BOARD_PACKET_SCOREBOARD_H
#define SELFPROJ_SIM_BOARD_PACKET_SCOREBOARD_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"

namespace selfproj::sim {

// Every packet must be the next one of its kind that the model expects, or a later one. The packets in between were
// lost, and the packet's own count of losses must say exactly that. Packets that are still expected at the end were
// lost too.
class PacketScoreboard {
 public:
  // The state of one kind of packet.
  struct Kind {
    std::uint64_t matched = 0;        // packets equal to the model's
    std::uint64_t lost = 0;           // packets that never came; after finish() all of them
    model::PacketHeader last_header;  // header of the last packet that matched
    std::uint32_t last_status = 0;
  };

  // Called before the first packet if the board's count of lost packets of the kind is already at `count`.
  void lost_before(std::uint8_t kind, std::uint32_t count) { streams_[index(kind)].lost_before = count; }

  // A packet of the model, with `lost` 0. Must come before the board's own.
  void expect(model::BoardPacket&& packet);

  // A packet of the board, no byte more or less. Returns false if it is not a packet, was not expected, or differs.
  bool compare(std::span<const std::uint8_t> bytes);

  // Says that no more packets will come.
  void finish();

  [[nodiscard]] const Kind& of(std::uint8_t kind) const { return streams_[index(kind)].known; }
  [[nodiscard]] std::uint64_t matched() const;  // packets of all kinds
  [[nodiscard]] std::uint64_t lost() const;     // packets of all kinds
  // The value that the board's counter of lost packets of this kind must have, modulo 2^32, including earlier losses.
  [[nodiscard]] std::uint32_t lost_in_all(std::uint8_t kind) const { return streams_[index(kind)].lost_in_all(); }

  [[nodiscard]] std::uint64_t matched_bytes() const { return matched_bytes_; }
  [[nodiscard]] std::uint64_t matched_columns() const { return matched_columns_; }  // in moments packets
  [[nodiscard]] std::uint64_t matched_codes() const { return matched_codes_; }      // pixels in code packets
  // The number of packets that matched, by their status.
  [[nodiscard]] const std::map<std::uint32_t, std::uint64_t>& by_status() const { return by_status_; }

  [[nodiscard]] std::uint64_t mismatches() const { return mismatches_; }
  // A description of the first mismatch; empty if there was none.
  [[nodiscard]] const std::string& first_mismatch() const { return first_mismatch_; }

 private:
  struct Stream {
    Kind known;
    std::deque<model::BoardPacket> expected;
    std::uint32_t lost_before = 0;

    [[nodiscard]] std::uint32_t lost_in_all() const { return lost_before + static_cast<std::uint32_t>(known.lost); }
  };

  static std::size_t index(std::uint8_t kind) {
    return static_cast<std::size_t>((model::one_for_a_frame(kind) ? spec::kKindMoments : kind) - spec::kKindMoments);
  }
  bool fail(const std::string& what);

  std::array<Stream, 3> streams_;  // one for each kind
  std::vector<std::uint8_t> want_;
  std::uint64_t matched_bytes_ = 0;
  std::uint64_t matched_columns_ = 0;
  std::uint64_t matched_codes_ = 0;
  std::map<std::uint32_t, std::uint64_t> by_status_;
  std::uint64_t mismatches_ = 0;
  std::string first_mismatch_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_PACKET_SCOREBOARD_H
