// Gives the pattern index as sp_frame_info does: some clocks after the start of a frame, when the next frame may
// already have begun.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_PATTERN_INDEX_H
#define SELFPROJ_TESTS_RTL_BLOCKS_PATTERN_INDEX_H

#include <cstdint>
#include <deque>
#include <utility>

namespace selfproj::test {

class PatternIndex {
 public:
  static constexpr int kDelay = 4;  // clocks from a frame's start to its index

  // A frame with this pattern starts in this clock. Call in the order of the clocks.
  void start(std::int64_t clock, int pattern) { coming_.emplace_back(clock + kDelay, pattern); }

  // Sets pattern_i if an index comes in this clock. Call in every clock.
  template <typename Dut>
  void drive(Dut& dut, std::int64_t clock) {
    if (!coming_.empty() && coming_.front().first == clock) {
      dut.pattern_i = static_cast<std::uint16_t>(coming_.front().second);
      coming_.pop_front();
    }
  }

 private:
  std::deque<std::pair<std::int64_t, int>> coming_;  // clock, pattern
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_PATTERN_INDEX_H
