// Judges the packets of a board against those of the model of the board: every byte, and every loss.
#ifndef SELFPROJ_SIM_BOARD_PACKET_JUDGE_H
#define SELFPROJ_SIM_BOARD_PACKET_JUDGE_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "model/board.h"
#include "model/packet.h"

namespace selfproj {

// Every packet must be the next one the model expects of its kind, or a later one: what is skipped was lost, and the
// packet's own count of losses must say exactly that. What is still expected at the end was lost too.
class PacketJudge {
 public:
  // What is known of the packets of a kind.
  struct Kind {
    std::uint64_t matched = 0;  // packets equal to the model's
    std::uint64_t lost = 0;     // packets that never came; after finish() all of them
    PacketHeader last_header;   // of the last one that matched
    std::uint32_t last_status = 0;
  };

  // Before the first packet: the board's count of lost packets of the kind stands at `count` already.
  void lost_before(std::uint8_t kind, std::uint32_t count) { streams_[index(kind)].lost_before = count; }

  // A packet of the model, with `lost` 0; before the board's own.
  void expect(BoardPacket&& packet);

  // A packet of the board, no byte more or less. False where it is no packet, was not to be expected, or differs.
  bool judge(std::span<const std::uint8_t> bytes);

  // No more packets come.
  void finish();

  [[nodiscard]] const Kind& of(std::uint8_t kind) const { return streams_[index(kind)].known; }
  [[nodiscard]] std::uint64_t matched() const;  // packets of all kinds
  [[nodiscard]] std::uint64_t lost() const;     // likewise
  // What the board's counter of lost packets of the kind must show, modulo 2^32: with those lost before.
  [[nodiscard]] std::uint32_t lost_in_all(std::uint8_t kind) const { return streams_[index(kind)].lost_in_all(); }

  [[nodiscard]] std::uint64_t matched_bytes() const { return matched_bytes_; }
  [[nodiscard]] std::uint64_t matched_columns() const { return matched_columns_; }  // of moments packets
  [[nodiscard]] std::uint64_t matched_codes() const { return matched_codes_; }      // pixels, of code packets
  // Packets that matched, by their status.
  [[nodiscard]] const std::map<std::uint32_t, std::uint64_t>& by_status() const { return by_status_; }

  [[nodiscard]] std::uint64_t mismatches() const { return mismatches_; }
  // What was wrong first; empty if nothing.
  [[nodiscard]] const std::string& first_mismatch() const { return first_mismatch_; }

 private:
  struct Stream {
    Kind known;
    std::deque<BoardPacket> expected;
    std::uint32_t lost_before = 0;

    [[nodiscard]] std::uint32_t lost_in_all() const { return lost_before + static_cast<std::uint32_t>(known.lost); }
  };

  static std::size_t index(std::uint8_t kind) { return static_cast<std::size_t>(kind - spec::kKindMoments); }
  bool fail(const std::string& what);

  std::array<Stream, 3> streams_;  // by kind
  std::vector<std::uint8_t> want_;
  std::uint64_t matched_bytes_ = 0;
  std::uint64_t matched_columns_ = 0;
  std::uint64_t matched_codes_ = 0;
  std::map<std::uint32_t, std::uint64_t> by_status_;
  std::uint64_t mismatches_ = 0;
  std::string first_mismatch_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_BOARD_PACKET_JUDGE_H
