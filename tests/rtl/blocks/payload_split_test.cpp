// Tests the splitting of words of 8 and 16 lanes into payload beats, with a reference written down from the guarantees
// of the module.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "Vsp_payload_split_ports.h"
#include "Vsp_payload_split_sixteen_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kFirstPart = 3;  // clocks from a word that finds nothing before it to its first beat
constexpr int kWords = 8;      // that wait in this build, besides the one that leaves

struct Part {
  std::int64_t from;  // clock in which the word came
  bool holds;         // a beat; else only the end of the payload
  bool ends;
  Word128 data;
};

// Payloads of any length with any gaps, which end or break with their last word or behind it. Every beat is compared in
// the clock in which it leaves.
template <typename Dut, int Lanes>
void split_payloads(Random& random) {
  constexpr int kParts = Lanes / 4;
  Clocked<Dut> split;
  split.valid_when({"data_o"}, [&] { return split->valid_o != 0; });
  split->words_valid_i = 0;
  split->words_break_i = 0;
  split.reset();
  std::deque<Part> parts;  // that have not left
  std::int64_t free_from = 0;
  int waiting = 0;  // entries that have not left
  const int eager = random.chance(40) ? 100 : random.between(5, 90);
  for (int clock = 0; clock < 600; ++clock) {
    const bool word = clock < 560 && waiting < kWords && random.chance(eager);
    const bool ends = clock < 560 && waiting < kWords && random.chance(word ? 10 : 5);
    split->words_valid_i = word;
    split->words_break_i = ends;
    for (int part = 0; part < kParts; ++part) {
      Word128 data;
      for (std::size_t i = 0; i < 4; ++i) {
        data[i] = static_cast<std::uint32_t>(random.bits());
        split->words_data_i[static_cast<std::size_t>(4 * part) + i] = data[i];
      }
      if (word) {
        parts.push_back({clock, true, ends && part == kParts - 1, data});
      }
    }
    if (ends && !word) {
      parts.push_back({clock, false, true, {}});
    }
    waiting += word || ends ? 1 : 0;
    split.settle();
    const bool due = !parts.empty() && clock >= parts.front().from + kFirstPart && clock >= free_from;
    ASSERT_EQ(split->valid_o != 0, due && parts.front().holds) << "clock " << clock;
    ASSERT_EQ(split->break_o != 0, due && parts.front().ends) << "clock " << clock;
    if (due) {
      if (parts.front().holds) {
        ASSERT_EQ(word128(split->data_o), parts.front().data) << "clock " << clock;
      }
      free_from = clock + 1;
      const std::int64_t from = parts.front().from;
      parts.pop_front();
      waiting -= parts.empty() || parts.front().from != from ? 1 : 0;
    }
    split.rise();
  }
  EXPECT_TRUE(parts.empty());
}

TEST(PayloadSplit, WordsOfEightLanes) { for_cases(60, split_payloads<Vsp_payload_split, 8>); }
TEST(PayloadSplit, WordsOfSixteenLanes) { for_cases(60, split_payloads<Vsp_payload_split_sixteen, 16>); }

}  // namespace
}  // namespace selfproj::test
