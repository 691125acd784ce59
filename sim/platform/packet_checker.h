// Compares the board's packets, byte for byte, with those of the model of the board.
#ifndef SELFPROJ_SIM_PLATFORM_PACKET_CHECKER_H
#define SELFPROJ_SIM_PLATFORM_PACKET_CHECKER_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "model/board.h"

namespace selfproj {

// Every packet must be the next one the model expects of its kind, or a later one: what is skipped was lost, and the
// packet's own count of losses must say exactly that. What is still expected at the end was lost too.
class PacketChecker {
 public:
  // A packet of the model, with `lost` 0; before the board's own.
  void expect(BoardPacket&& packet);

  // A packet of the board. False where it is no packet, was not to be expected, or differs.
  bool check(std::span<const std::uint8_t> bytes);

  // No more packets come.
  void finish();

  [[nodiscard]] std::uint64_t matched() const { return matched_; }
  [[nodiscard]] std::uint64_t matched_columns() const { return matched_columns_; }  // of moments packets
  [[nodiscard]] std::uint64_t matched_codes() const { return matched_codes_; }      // pixels, of code packets
  [[nodiscard]] std::uint64_t mismatches() const { return mismatches_; }
  [[nodiscard]] std::uint64_t lost() const { return lost_[0] + lost_[1] + lost_[2]; }  // of all kinds
  // Of packets of a kind.
  [[nodiscard]] std::uint64_t lost(std::uint8_t kind) const { return lost_[index(kind)]; }
  // What was wrong first; empty if nothing.
  [[nodiscard]] const std::string& first_mismatch() const { return first_mismatch_; }

 private:
  static std::size_t index(std::uint8_t kind) { return static_cast<std::size_t>(kind - spec::kKindMoments); }
  bool fail(const std::string& what);

  std::array<std::deque<BoardPacket>, 3> expected_;  // by kind
  std::array<std::uint64_t, 3> lost_{};
  std::vector<std::uint8_t> want_;
  std::uint64_t matched_ = 0;
  std::uint64_t matched_columns_ = 0;
  std::uint64_t matched_codes_ = 0;
  std::uint64_t mismatches_ = 0;
  std::string first_mismatch_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_PLATFORM_PACKET_CHECKER_H
