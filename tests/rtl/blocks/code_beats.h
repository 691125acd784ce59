// Streams of words of 16 bits, four a beat, with the places of their beats: codes, and what is made of them.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_CODE_BEATS_H
#define SELFPROJ_TESTS_RTL_BLOCKS_CODE_BEATS_H

#include <gtest/gtest.h>

#include <cstdint>
#include <map>

namespace selfproj::test {

// Leftmost in the low bits.
inline std::uint64_t four_words(const std::uint16_t* words) {
  return words[0] | std::uint64_t{words[1]} << 16U | std::uint64_t{words[2]} << 32U | std::uint64_t{words[3]} << 48U;
}

struct CodeBeat {
  std::uint64_t words = 0;
  bool start = false, line_start = false, line_end = false;
  bool operator==(const CodeBeat&) const = default;
};

// What is to come out of a circuit, by clock: beats, and breaks with their status.
struct CodesDue {
  std::map<std::int64_t, CodeBeat> beats;
  std::map<std::int64_t, std::uint32_t> breaks;
  std::uint64_t pixels = 0;  // that came

  [[nodiscard]] bool empty() const { return beats.empty() && breaks.empty(); }

  // The outputs of a clock. `beat` counts only if it is `valid`, `status` only if the image `breaks_now`.
  void check(std::int64_t clock, bool valid, const CodeBeat& beat, bool breaks_now, std::uint32_t status) {
    const auto due = beats.extract(clock);
    ASSERT_EQ(valid, !due.empty()) << "clock " << clock;
    if (valid) {
      ASSERT_EQ(beat.words, due.mapped().words) << "clock " << clock;
      ASSERT_TRUE(beat == due.mapped()) << "the place of the beat, clock " << clock;
      pixels += 4;
    }
    const auto due_break = breaks.extract(clock);
    ASSERT_EQ(breaks_now, !due_break.empty()) << "clock " << clock;
    if (breaks_now) {
      ASSERT_EQ(status, due_break.mapped()) << "clock " << clock;
    }
  }
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CODE_BEATS_H
