// Tests the front end for serial LVDS sensors from the bits of the lanes on: skew, jitter, any place where the
// deserializer cuts its words, damaged words, cables that are pulled, and lanes that are dead.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "Vsp_lvds_cmv2000_ports.h"
#include "Vsp_lvds_codes_ports.h"
#include "Vsp_lvds_codes_two_ports.h"
#include "Vsp_lvds_sensor_four_ports.h"
#include "Vsp_lvds_sensor_one_ports.h"
#include "Vsp_lvds_sensor_ports.h"
#include "tests/rtl/blocks/lvds_bench.h"
#include "tests/rtl/blocks/lvds_reference.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr LvdsFormat kSixteen = {.taps = 16};
constexpr LvdsFormat kFour = {.lanes = 4, .bits = 12, .msb_first = true, .columns = 16, .burst = 8};
constexpr LvdsFormat kOne = {.lanes = 1, .columns = 24, .burst = 24, .taps = 12};
constexpr LvdsFormat kCodes = {.lanes = 4, .codes = true, .msb_first = true, .taps = 24};
constexpr LvdsFormat kCodesTwo = {.lanes = 2, .bits = 8, .codes = true, .msb_first = true};

// Words for the training of all lanes at all taps, with some to spare
int training_words(const LvdsFormat& format) { return (format.lanes + 1) * (format.taps + 3) * 400 + 3000; }

// Lanes that are early or late by up to 1.2 bits, and edges that come up to a quarter of a bit early or late. Without
// taps, all of it stays within half a bit.
template <typename Dut>
void disturb(LvdsBench<Dut>& bench, const LvdsFormat& format) {
  for (std::size_t lane = 0; lane <= static_cast<std::size_t>(format.lanes); ++lane) {
    const int most = format.taps > 1 ? 1200 : 240;
    bench.skew[lane] = bench.random().between(-most, most);
    bench.jitter[lane] = bench.random().between(0, 240);
  }
}

// Frames of random sizes, with any gaps, clocks, skews and places.
template <typename Dut>
void expect_every_beat(const LvdsFormat& format, int cases) {
  for_cases(cases, [&](Random& random, std::uint64_t seed) {
    // The board takes what comes: a word of all lanes gives at most lanes / 4 beats.
    const int word = 1000 * std::max(format.lanes, 4) / 4;
    LvdsBench<Dut> bench(seed, format, word, random.between(300, 990));
    disturb(bench, format);
    bench.valid_percent = random.chance(50) ? 100 : random.between(40, 90);
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    EXPECT_EQ(bench.failed(), 0U);
    for (int frame = 0; frame < 8; ++frame) {
      bench.send(random.between(1, 6), random.between(2, 12), random.chance(50) ? 1 : 9, random.between(3, 60));
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_EQ(bench.overruns() + bench.cuts() + bench.losses(), 0);
    EXPECT_EQ(bench.damaged(), 0U);
  });
}
TEST(LvdsSensor, SixteenLanes) { expect_every_beat<Vsp_lvds_sensor>(kSixteen, 6); }
TEST(LvdsSensor, FourLanesOfTwelveBits) { expect_every_beat<Vsp_lvds_sensor_four>(kFour, 10); }
TEST(LvdsSensor, OneLane) { expect_every_beat<Vsp_lvds_sensor_one>(kOne, 10); }
TEST(LvdsSensor, Codes) { expect_every_beat<Vsp_lvds_codes>(kCodes, 10); }
TEST(LvdsSensor, CodesOfEightBitsOnTwoLanes) { expect_every_beat<Vsp_lvds_codes_two>(kCodesTwo, 10); }

// Wherever the deserializer cuts its words, and with each lane up to three bits from the control lane, to either side.
template <typename Dut>
void expect_every_place(const LvdsFormat& format) {
  for_cases(format.bits, [&](Random&, std::uint64_t seed) {
    for (int shift = 0; shift < 7; ++shift) {
      LvdsBench<Dut> bench(seed, format, 1000, 990);
      bench.set_place(static_cast<int>(seed) - 1);
      for (int lane = 0; lane < format.lanes; ++lane) {
        bench.skew[static_cast<std::size_t>(lane)] = kLvdsTicks * ((shift + 2 * lane) % 7 - 3);
      }
      ASSERT_TRUE(bench.wait_aligned(training_words(format)));
      bench.send(3, 6, 3, 20);
      bench.send(2, 5, 3, 20);
      bench.drain();
      EXPECT_EQ(bench.expect_frames_sent(), 0) << "shift " << shift;
      EXPECT_EQ(bench.damaged(), 0U);
    }
  });
}
TEST(LvdsSensor, AnyPlaceOfTwelve) { expect_every_place<Vsp_lvds_sensor_four>(kFour); }
TEST(LvdsSensor, AnyPlaceOfTenWithTaps) { expect_every_place<Vsp_lvds_sensor_one>(kOne); }
TEST(LvdsSensor, AnyPlaceOfEight) { expect_every_place<Vsp_lvds_codes_two>(kCodesTwo); }

// Each lane's tap puts the edges as far from the samples as its steps allow, in ticks, also where the cable was out
// when the training began.
template <typename Dut>
void expect_middle_taps(const LvdsFormat& format, int from_edges) {
  for_cases(12, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000, 990);
    disturb(bench, format);
    if (seed % 2 == 0) {
      bench.pulled = true;
      bench.reset();
      bench.words_in(random.between(0, 600 * format.taps));
      bench.pulled = false;
    }
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    for (int lane = 0; lane <= format.lanes; ++lane) {
      const int edge = bench.skew[static_cast<std::size_t>(lane)] + bench.tap(lane) * bench.tap_ticks;
      const int from_sample = std::abs(((edge - kLvdsTicks / 2) % kLvdsTicks + kLvdsTicks) % kLvdsTicks);
      EXPECT_GE(std::min(from_sample, kLvdsTicks - from_sample), from_edges)
          << "lane " << lane << ", tap " << bench.tap(lane);
    }
  });
}
TEST(LvdsSensor, TapsInTheMiddleOfTheBits) { expect_middle_taps<Vsp_lvds_codes>(kCodes, 330); }
TEST(LvdsSensor, FewTapsInTheMiddleOfTheBits) { expect_middle_taps<Vsp_lvds_sensor_one>(kOne, 300); }

// Without jitter every tap is right, and an edge ends a run of taps: the tap is the middle of the longest run, of
// equally long ones the first.
int middle_of_longest_run(int taps, int tap_ticks, int skew) {
  const auto bit_at = [&](int tap) {
    return (3000 * kLvdsTicks + kLvdsTicks / 2 - skew - tap * tap_ticks) / kLvdsTicks;
  };
  int best_first = 0;
  int best = 0;
  for (int first = 0, tap = 0; tap < taps; ++tap) {
    first = bit_at(tap) == bit_at(first) ? first : tap;
    if (tap - first + 1 > best) {
      best_first = first;
      best = tap - first + 1;
    }
  }
  return best_first + best / 2;
}

template <typename Dut>
void expect_exact_taps(const LvdsFormat& format) {
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000, 990);
    bench.tap_ticks = random.between(90, 400);
    for (int lane = 0; lane <= format.lanes; ++lane) {
      bench.skew[static_cast<std::size_t>(lane)] = random.between(-1200, 1200);
    }
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    for (int lane = 0; lane <= format.lanes; ++lane) {
      const int skew = bench.skew[static_cast<std::size_t>(lane)];
      EXPECT_EQ(bench.tap(lane), middle_of_longest_run(format.taps, bench.tap_ticks, skew))
          << "lane " << lane << ", skew " << skew << ", " << bench.tap_ticks << " ticks a tap";
    }
  });
}
TEST(LvdsSensor, TheMiddleTapExactly) { expect_exact_taps<Vsp_lvds_codes>(kCodes); }
TEST(LvdsSensor, TheMiddleOfFewTapsExactly) { expect_exact_taps<Vsp_lvds_sensor_one>(kOne); }

// A tap takes as long as the training's description says: new taps have Settle words (16) to show, the lane's word must
// come 2^LogWindow (16) times, and a dead lane is given up after 2^LogPatience words.
template <typename Dut>
void expect_time_of_a_tap(const LvdsFormat& format, int patience) {
  for_cases(2, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000, 990);
    const int lane = random.between(0, format.lanes);
    const bool dead = seed % 2 == 0;
    bench.dead[static_cast<std::size_t>(lane)] = dead;
    bench.reset();
    std::int64_t since = 0;
    int seen = 0;
    for (int before = bench.tap(lane); seen < format.taps - 1; before = bench.tap(lane)) {
      ASSERT_LT(bench.words(), training_words(format));
      bench.words_in(1);
      if (bench.tap(lane) == before + 1) {
        const std::int64_t took = bench.words() - since;
        const int window = dead ? patience : 16;
        if (seen > 0 && bench.tap(lane) > 1) {
          // A pulse is 8 clocks; where the word is found, four steps follow.
          EXPECT_GE(took, 16 + window + (dead ? 8 : 12)) << "lane " << lane << ", tap " << before;
          EXPECT_LE(took, 16 + window + format.bits + 28) << "lane " << lane << ", tap " << before;
        }
        since = bench.words();
        ++seen;
      }
    }
  });
}
TEST(LvdsSensor, TheTimeOfATapOfOneLane) { expect_time_of_a_tap<Vsp_lvds_sensor_one>(kOne, 1024); }
TEST(LvdsSensor, TheTimeOfATapWithCodes) { expect_time_of_a_tap<Vsp_lvds_codes>(kCodes, 512); }

// Where the control lane is lost while the delay of a data lane moves, the pulse is still a whole one (the bench looks
// at each), and the training begins again.
TEST(LvdsSensor, PulsesAreWholeWhereTheControlLaneIsLost) {
  for_cases(4, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Vsp_lvds_sensor_one> bench(seed, kOne, 1000, 990);
    for (int loss = 0; loss < 30; ++loss) {
      bench.reset();
      while (bench.tap(0) == 0) {
        bench.words_in(1);
      }
      bench.words_in(random.between(0, 400));
      ASSERT_FALSE(bench.aligned());
      for (int word = 0; word < 7; ++word) {
        bench.frames().queue().push_back(bench.frames().idle());
        bench.frames().queue().back().control ^= 0x300U;
      }
      bench.words_in(60);
    }
    EXPECT_TRUE(bench.wait_aligned(training_words(kOne)));
  });
}

// A word that comes often, but never as many times in a row as a measurement takes, trains no lane, whatever clocks
// without a word lie between.
TEST(LvdsSensor, WordsThatChangeTrainNoLane) {
  for_cases(4, [&](std::uint64_t seed) {
    LvdsBench<Vsp_lvds_sensor_one> bench(seed, kOne, 1000, 990);
    bench.valid_percent = 40;
    auto& queue = bench.frames().queue();
    for (int word = 0; word < 2 * training_words(kOne); ++word) {
      queue.push_back(bench.frames().idle());
      if (word % 12 == 0) {
        queue.back().control ^= 0x80U;
      }
    }
    while (!queue.empty()) {
      bench.words_in(1);
      ASSERT_FALSE(bench.aligned());
    }
    EXPECT_EQ(bench.failed(), 2U);
    EXPECT_TRUE(bench.wait_aligned(training_words(kOne)));
  });
}

// A frame that lasts longer than any measurement of a lane.
template <typename Dut>
void expect_long_frame(const LvdsFormat& format) {
  LvdsBench<Dut> bench(1, format, 1000 * std::max(format.lanes, 4) / 4, 900);
  ASSERT_TRUE(bench.wait_aligned(training_words(format)));
  bench.send(200, 12, 1, 20);
  bench.drain();
  EXPECT_EQ(bench.expect_frames_sent(), 0);
  EXPECT_EQ(bench.cuts() + bench.losses() + bench.overruns(), 0);
}
TEST(LvdsSensor, ALongFrameOfFourLanes) { expect_long_frame<Vsp_lvds_sensor_four>(kFour); }
TEST(LvdsSensor, ALongFrameOfOneLane) { expect_long_frame<Vsp_lvds_sensor_one>(kOne); }
TEST(LvdsSensor, ALongFrameOfCodes) { expect_long_frame<Vsp_lvds_codes_two>(kCodesTwo); }

// The rates of the mission by the clocks' ratios: words of 48 MHz (480 Mbit/s), the board's 151.2 MHz. `gap`: words
// between the frames, as the exposure needs them.
template <typename Dut>
void expect_rate(const LvdsFormat& format, int rows, int gap, double frames_a_second) {
  constexpr int kWord = 20833;  // ps
  constexpr int kBoard = 6614;
  LvdsBench<Dut> bench(1, format, kWord, kBoard);
  disturb(bench, format);
  ASSERT_TRUE(bench.wait_aligned(training_words(format)));
  constexpr int kFrames = 5;
  for (int frame = 0; frame < kFrames; ++frame) {
    bench.send(rows, 0, 1, gap);
  }
  const double seconds = static_cast<double>(bench.frames().queue().size()) / kFrames * kWord * 1e-12;
  EXPECT_GE(1 / seconds, frames_a_second);
  bench.set_beats_waiting(20000);
  bench.drain();
  EXPECT_EQ(bench.expect_frames_sent(), 0);
  EXPECT_EQ(bench.overruns() + bench.cuts() + bench.losses(), 0);
}
TEST(LvdsSensor, TenThousandFramesOf96Rows) { expect_rate<Vsp_lvds_sensor>(kSixteen, 96, 1300, 10'000); }
TEST(LvdsSensor, FiftyThousandFramesOf20Rows) { expect_rate<Vsp_lvds_sensor>(kSixteen, 20, 264, 50'000); }
// A CMV2000: 2,048 columns, 129 words a row, 12 rows between frames, the FIFO that docs/cameras.md says
TEST(LvdsSensor, Cmv2000With25Rows) {
  expect_rate<Vsp_lvds_cmv2000>({.columns = 128, .burst = 128}, 25, 12 * 129, 10'000);
}

// One word in a hundred is wrong: each word in which this can be noticed is counted, its frame cut off, and every other
// frame is whole.
template <typename Dut, typename Reference>
void expect_damage_counted(const LvdsFormat& format, const Reference& reference, int cases) {
  int cut = 0;
  int whole = 0;
  for_cases(cases, [&](Random& random, std::uint64_t seed) {
    const int word = 1000 * std::max(format.lanes, 4) / 4;
    LvdsBench<Dut> bench(seed, format, word, 700);
    bench.valid_percent = random.chance(50) ? 100 : random.between(40, 90);
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    bench.words_in(40);
    std::vector<LvdsWord> words;
    bench.record = &words;
    bench.damage_percent = 1;
    for (int frame = 0; frame < 60; ++frame) {
      bench.send(random.between(1, 8), random.between(2, 8), random.chance(50) ? 1 : 5,
                 random.between(8, 3 * format.columns));
    }
    bench.drain();
    bench.damage_percent = 0;
    bench.words_in(20);
    const LvdsExpected expected = Reference(reference).of(words);
    const int lost = expect_frames(bench.beats(), expected.frames, expected.may_break);
    EXPECT_GT(expected.damaged, 10U);
    EXPECT_EQ(bench.damaged(), expected.damaged & 0xFFFFU);
    EXPECT_EQ(bench.cuts(), expected.cuts);
    EXPECT_EQ(bench.losses(), 0);
    EXPECT_TRUE(bench.aligned());
    cut += lost;
    whole += static_cast<int>(expected.frames.size()) - lost;
  });
  if (runs_all_cases()) {
    EXPECT_GT(cut, 5 * cases);
    EXPECT_GT(whole, 10 * cases);
  }
}
TEST(LvdsSensor, DamagedWordsAreCounted) {
  expect_damage_counted<Vsp_lvds_sensor>(kSixteen, LvdsFlagsReference(kSixteen), 3);
}
TEST(LvdsSensor, DamagedWordsAreCountedInBursts) {
  expect_damage_counted<Vsp_lvds_sensor_four>(kFour, LvdsFlagsReference(kFour), 10);
}
TEST(LvdsSensor, DamagedWordsAreCountedOnOneLane) {
  expect_damage_counted<Vsp_lvds_sensor_one>(kOne, LvdsFlagsReference(kOne), 10);
}
TEST(LvdsSensor, DamagedWordsAreCountedWithCodes) {
  expect_damage_counted<Vsp_lvds_codes>(kCodes, LvdsCodesReference(kCodes, true), 10);
}
TEST(LvdsSensor, DamagedWordsAreCountedWithCodesOfEightBits) {
  expect_damage_counted<Vsp_lvds_codes_two>(kCodesTwo, LvdsCodesReference(kCodesTwo, false), 10);
}

// With codes: each word that there is, in the place of each word of a frame of two lines and of the gap behind it.
template <typename Dut>
void expect_every_word(const LvdsFormat& format, const LvdsCodesReference& reference) {
  constexpr unsigned kCases = 8;  // each of every eighth word
  for_cases(kCases, [&](Random&, std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000, 700);
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    bench.words_in(40);
    std::vector<LvdsWord> words;
    bench.record = &words;
    auto& queue = bench.frames().queue();
    for (unsigned word = seed % kCases; word < 1U << static_cast<unsigned>(format.bits); word += kCases) {
      // Lines of black pixels come and go, so that frames are not equally long.
      for (std::size_t at = 0, end = 1; at < end; ++at) {
        bench.send(2, 3, 1, 9);
        std::size_t first = 0;
        while (queue[first].control != format.code(0x2AA)) {
          ++first;
        }
        end = queue.size() - first;
        queue[first + std::min(at, end - 1)].control = word;
        while (!queue.empty()) {
          bench.step();
        }
      }
    }
    // And directly before the code that starts a frame
    for (const unsigned word : kLvdsCodes) {
      bench.send(3, 3, 1, 9);
      while (queue.front().control != format.code(0x2AA)) {
        queue.pop_front();
      }
      LvdsWord before = bench.frames().idle();
      queue.push_front(before);
      before.control = format.code(word);
      queue.insert(queue.begin() + 1, before);
      while (!queue.empty()) {
        bench.step();
      }
    }
    bench.drain();
    bench.words_in(20);
    const LvdsExpected expected = LvdsCodesReference(reference).of(words);
    expect_frames(bench.beats(), expected.frames, expected.may_break);
    EXPECT_EQ(bench.damaged(), expected.damaged & 0xFFFFU);
    EXPECT_EQ(bench.cuts(), expected.cuts);
    EXPECT_EQ(bench.losses(), 0);
  });
}
TEST(LvdsSensor, EveryWordAtEveryPlace) { expect_every_word<Vsp_lvds_codes>(kCodes, {kCodes, true}); }
TEST(LvdsSensor, EveryWordOfEightBitsAtEveryPlace) {
  expect_every_word<Vsp_lvds_codes_two>(kCodesTwo, {kCodesTwo, false});
}

// With codes and check words: each line with a wrong pixel is counted, and no frame is broken.
TEST(LvdsSensor, WrongPixelsAreCountedByTheCheckWords) {
  for_cases(6, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Vsp_lvds_codes> bench(seed, kCodes, 1000, 700);
    ASSERT_TRUE(bench.wait_aligned(training_words(kCodes)));
    bench.words_in(40);
    unsigned hit = 0;
    for (int frame = 0; frame < 40; ++frame) {
      const std::size_t before = bench.frames().queue().size();
      bench.send(1, random.between(2, 8), 4, random.between(6, 60));
      auto& queue = bench.frames().queue();
      std::size_t first = before;
      while (queue[first].control != 0x2AA) {
        ++first;
      }
      std::size_t check = first;
      while (queue[check].control != 0x059) {
        ++check;
      }
      if (random.chance(40)) {
        // One bit of a pixel, of those that go on, or of the check word
        const auto at = static_cast<std::size_t>(random.between(0, static_cast<int>(check - first)));
        const auto lane = static_cast<std::size_t>(random.between(0, kCodes.lanes - 1));
        queue[first + at].data[lane] ^= 1U << static_cast<unsigned>(random.between(0, 9));
        bench.sent().back() = bench.frames().line_of(first, check);
        ++hit;
      }
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_EQ(bench.damaged(), hit);
    EXPECT_EQ(bench.cuts() + bench.losses(), 0);
  });
}

// The cable is pulled within frames, and put back: the deserializer then cuts its words anywhere. Frames that begin
// after all lanes are aligned are whole. Flags of exposure and overhead stand in the gaps.
template <typename Dut>
void expect_cable_put_back(const LvdsFormat& format, int gap) {
  int broken = 0;
  int whole = 0;
  for_cases(8, [&](Random& random, std::uint64_t seed) {
    const int word = 1000 * std::max(format.lanes, 4) / 4;
    LvdsBench<Dut> bench(seed, format, word, 700);
    disturb(bench, format);
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    // With 0x20 alone, the words of a gap have two turns that look like the idle word.
    constexpr std::array<unsigned, 4> kFlags = {0x00, 0x60, 0x20, 0x20};
    bench.frames().set_flags(kFlags[seed % kFlags.size()]);
    bench.watch();
    for (int round = 0; round < 3; ++round) {
      for (int frame = 0; frame < 40; ++frame) {
        bench.send(random.between(4, 8), random.between(4, 8), 2, gap);
      }
      bench.words_in(random.between(300, 900));
      // Pixels that are half lost together with a window's number, 0, are noticed by nothing but check words.
      while (bench.zeros_on_their_way()) {
        bench.words_in(1);
      }
      bench.pulled = true;
      bench.words_in(random.between(20, 2000));
      bench.pulled = false;
      bench.set_place(random.between(0, format.bits - 1));
      ASSERT_TRUE(bench.wait_aligned(static_cast<int>(bench.frames().queue().size()))) << "never aligned again";
      bench.drain();
      EXPECT_FALSE(bench.may_break().back()) << "not aligned when the last frame came";
    }
    const int lost = bench.expect_frames_sent();
    broken += lost;
    whole += static_cast<int>(bench.sent().size()) - lost;
    EXPECT_GE(bench.losses(), 3);
  });
  if (runs_all_cases()) {
    EXPECT_GT(broken, 12);
    EXPECT_GT(whole, 100);
  }
}
TEST(LvdsSensor, TheCableIsPulledAndPutBack) { expect_cable_put_back<Vsp_lvds_sensor>(kSixteen, 200); }
TEST(LvdsSensor, TheCableIsPulledAndPutBackWithBursts) { expect_cable_put_back<Vsp_lvds_sensor_four>(kFour, 120); }
TEST(LvdsSensor, TheCableOfOneLaneIsPulledAndPutBack) { expect_cable_put_back<Vsp_lvds_sensor_one>(kOne, 120); }
TEST(LvdsSensor, TheCableIsPulledAndPutBackWithCodes) { expect_cable_put_back<Vsp_lvds_codes>(kCodes, 120); }
TEST(LvdsSensor, TheCableIsPulledAndPutBackWithCodesOfEightBits) {
  expect_cable_put_back<Vsp_lvds_codes_two>(kCodesTwo, 120);
}

// From every place where the deserializer may cut its words to every other, with a flag in the gaps that makes two
// turns of a word look like the idle one: the wrong turn is left as soon as a frame comes.
template <typename Dut>
void expect_every_other_place(const LvdsFormat& format) {
  for_cases(format.bits, [&](std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000 * std::max(format.lanes, 4) / 4, 700);
    bench.watch();
    for (int place = 0; place < format.bits; ++place) {
      bench.set_place(static_cast<int>(seed) - 1);
      bench.reset();
      bench.frames().set_flags(0);
      ASSERT_TRUE(bench.wait_aligned(training_words(format)));
      bench.frames().set_flags(0x20);
      bench.pulled = true;
      bench.words_in(40);
      bench.pulled = false;
      bench.set_place(place);
      for (int frame = 0; frame < 12; ++frame) {
        bench.send(4, 0, 1, 120);
      }
      bench.drain();
      ASSERT_FALSE(bench.may_break().back()) << "not aligned at place " << place;
    }
    bench.expect_frames_sent();
  });
}
TEST(LvdsSensor, EveryPlaceAfterEveryOther) { expect_every_other_place<Vsp_lvds_sensor_four>(kFour); }
TEST(LvdsSensor, EveryPlaceAfterEveryOtherOfOneLane) { expect_every_other_place<Vsp_lvds_sensor_one>(kOne); }

// The rule by which a lane is lost, from its description: wrong words are worth five, right ones take one away, and a
// wrong word at 27 or more is the last. Random patterns come close to it in the gaps, of one lane at a time.
template <typename Dut>
void expect_losses_by_the_rule(const LvdsFormat& format, int cases) {
  for_cases(cases, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000 * std::max(format.lanes, 4) / 4, 700);
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    bench.words_in(40);
    for (int losses = 1; losses <= 6; ++losses) {
      const int lane = random.between(0, format.lanes);
      const int wrong_percent = random.between(15, 100);
      int level = 0;
      std::vector<LvdsWord> words;
      for (bool lost = false; !lost;) {
        const bool wrong = random.chance(level > 0 && words.size() > 400 ? 100 : wrong_percent);
        lost = wrong && level >= 27;
        level = wrong ? level + 5 : std::max(0, level - 1);
        words.push_back(bench.frames().idle());
        if (wrong) {
          unsigned& word =
              lane == format.lanes ? words.back().control : words.back().data[static_cast<std::size_t>(lane)];
          word ^= format.codes || lane < format.lanes ? 1U : 0x300U;  // no code, no training word, no flags
        }
      }
      // All of them but the last, and right ones behind them
      bench.frames().queue().insert(bench.frames().queue().end(), words.begin(), words.end() - 1);
      bench.drain();
      ASSERT_EQ(bench.losses(), losses - 1) << "lane " << lane;
      bench.words_in(60);  // the level is 0 again
      bench.frames().queue().insert(bench.frames().queue().end(), words.begin(), words.end());
      bench.drain();
      ASSERT_EQ(bench.losses(), losses) << "lane " << lane;
      ASSERT_TRUE(bench.wait_aligned(training_words(format)));
      bench.words_in(40);
    }
  });
}
TEST(LvdsSensor, LanesAreLostByTheRule) { expect_losses_by_the_rule<Vsp_lvds_sensor_four>(kFour, 10); }
TEST(LvdsSensor, OneLaneIsLostByTheRule) { expect_losses_by_the_rule<Vsp_lvds_sensor_one>(kOne, 10); }
TEST(LvdsSensor, LanesAreLostByTheRuleWithCodes) { expect_losses_by_the_rule<Vsp_lvds_codes>(kCodes, 10); }
TEST(LvdsSensor, LanesAreLostByTheRuleWithCodesOfEightBits) {
  expect_losses_by_the_rule<Vsp_lvds_codes_two>(kCodesTwo, 10);
}

// More damaged words than the counter has numbers, each lane seldom enough to be kept.
template <typename Dut>
void expect_the_count_to_wrap(const LvdsFormat& format) {
  LvdsBench<Dut> bench(1, format, 1000, 700);
  ASSERT_TRUE(bench.wait_aligned(training_words(format)));
  bench.words_in(40);
  const unsigned before = bench.damaged();
  unsigned count = 0;
  for (int word = 0; count < 70'000; ++word) {
    LvdsWord sent = bench.frames().idle();
    const int lane = word % 7;
    if (lane < format.lanes) {
      sent.data[static_cast<std::size_t>(lane)] ^= 1U;
      ++count;
    }
    bench.frames().queue().push_back(sent);
    if (word % 1000 == 0) {
      bench.drain();
      ASSERT_EQ(bench.damaged(), (before + count) & 0xFFFFU);
    }
  }
  EXPECT_EQ(bench.losses(), 0);
}
TEST(LvdsSensor, TheCountOfDamagedWordsWraps) { expect_the_count_to_wrap<Vsp_lvds_sensor_four>(kFour); }
TEST(LvdsSensor, TheCountOfDamagedWordsOfOneLaneWraps) { expect_the_count_to_wrap<Vsp_lvds_sensor_one>(kOne); }
TEST(LvdsSensor, TheCountOfDamagedWordsWrapsWithCodes) { expect_the_count_to_wrap<Vsp_lvds_codes>(kCodes); }

// A single data lane goes dead within frames: it is lost and told, and frames come again when it is back.
TEST(LvdsSensor, ALaneThatGoesDeadIsLost) {
  for_cases(8, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Vsp_lvds_sensor_four> bench(seed, kFour, 1000, 700);
    ASSERT_TRUE(bench.wait_aligned(training_words(kFour)));
    for (int frame = 0; frame < 60; ++frame) {
      bench.send(random.between(3, 6), 0, 2, 120);
    }
    bench.words_in(random.between(300, 900));
    const auto lane = static_cast<std::size_t>(random.between(0, kFour.lanes - 1));
    bench.dead[lane] = true;
    for (int word = 0; word < 20'000 && bench.losses() == 0; ++word) {
      bench.words_in(1);
    }
    ASSERT_EQ(bench.losses(), 1);
    const std::int64_t lost = bench.words();
    while (bench.failed() == 0 && bench.words() < lost + 4000) {
      bench.words_in(1);
    }
    EXPECT_GE(bench.words() - lost, 1024 + 16);  // 2^LogPatience, Settle
    EXPECT_LE(bench.words() - lost, 1024 + 16 + 40);
    bench.words_in(2000);
    EXPECT_FALSE(bench.aligned());
    EXPECT_EQ(bench.losses(), 1);
    EXPECT_EQ(bench.failed(), 1U << lane);
    bench.dead[lane] = false;
    ASSERT_TRUE(bench.wait_aligned(4000));
    EXPECT_EQ(bench.failed(), 0U);
    bench.drain();
    bench.forget();
    for (int frame = 0; frame < 3; ++frame) {
      bench.send(random.between(3, 6), 0, 2, 120);
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
  });
}

// The control lane is lost while a data lane is measured: that lane is not told as one that gives no result.
template <typename Dut>
void expect_no_lane_blamed(const LvdsFormat& format) {
  for_cases(4, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000 * std::max(format.lanes, 4) / 4, 700);
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    bench.words_in(40);
    const auto lane = static_cast<std::size_t>(random.between(0, format.lanes - 1));
    bench.dead[lane] = true;
    bench.words_in(random.between(30, 100));
    EXPECT_EQ(bench.losses(), 1);
    bench.pulled = true;
    bench.words_in(random.between(30, 100));
    bench.pulled = false;
    bench.dead[lane] = false;
    unsigned failed = 0;
    for (int i = 0; i < 5000; ++i) {
      bench.step([&] { failed |= bench.failed(); });
    }
    EXPECT_EQ(failed, 0U);
    EXPECT_TRUE(bench.aligned());
  });
}
TEST(LvdsSensor, NoLaneIsBlamedForTheControlLane) { expect_no_lane_blamed<Vsp_lvds_sensor_four>(kFour); }
TEST(LvdsSensor, TheOnlyLaneIsNotBlamedForTheControlLane) { expect_no_lane_blamed<Vsp_lvds_sensor_one>(kOne); }
TEST(LvdsSensor, NoLaneOfCodesIsBlamedForTheControlLane) { expect_no_lane_blamed<Vsp_lvds_codes_two>(kCodesTwo); }

// With codes, a data lane is lost between two lines of a frame and trained before the next one. The frame has ended,
// and the start of the next one stands at no wrong place.
TEST(LvdsSensor, ALaneLostBetweenLinesEndsTheFrame) {
  for_cases(4, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Vsp_lvds_codes_two> bench(seed, kCodesTwo, 1000, 700);
    ASSERT_TRUE(bench.wait_aligned(training_words(kCodesTwo)));
    bench.words_in(40);
    bench.send(2, random.between(2, 6), 0, 0);
    bench.may_break().back() = true;
    auto& queue = bench.frames().queue();
    const auto is_line_start = [](const LvdsWord& word) { return word.control == kCodesTwo.code(0x0AA); };
    queue.erase(std::find_if(queue.begin(), queue.end(), is_line_start), queue.end());
    bench.frames().pause(60);
    while (queue.size() > 50) {
      bench.step();
    }
    bench.dead[0] = true;
    while (!queue.empty()) {
      bench.step();
    }
    EXPECT_EQ(bench.losses(), 1);
    const unsigned damaged = bench.damaged();
    EXPECT_GT(damaged, 0U);
    bench.dead[0] = false;
    ASSERT_TRUE(bench.wait_aligned(4000));
    bench.words_in(40);
    EXPECT_EQ(bench.cuts(), 1);
    bench.send(3, random.between(2, 6), 2, 40);
    bench.drain();
    EXPECT_EQ(bench.damaged(), damaged);
    EXPECT_EQ(bench.cuts(), 1);
    EXPECT_EQ(bench.expect_frames_sent(), 1);
  });
}

// The sensor's clock stops within a frame, and the deserializer cuts its words elsewhere afterwards.
TEST(LvdsSensor, TheClockStopsAndStarts) {
  for_cases(6, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Vsp_lvds_sensor_four> bench(seed, kFour, 1000, 700);
    ASSERT_TRUE(bench.wait_aligned(training_words(kFour)));
    for (int frame = 0; frame < 40; ++frame) {
      bench.send(random.between(3, 6), 0, 2, 120);
    }
    bench.words_in(random.between(300, 900));
    bench.stopped = true;
    bench.board_clocks(random.between(1, 500));
    bench.stopped = false;
    const int turn = random.between(1, kFour.bits - 1);
    bench.watch();
    bench.set_place((turn + static_cast<int>(seed)) % kFour.bits);
    bench.pulled = true;  // while the words come to the new place
    bench.words_in(1);
    bench.pulled = false;
    bench.words_in(60);
    ASSERT_TRUE(bench.wait_aligned(static_cast<int>(bench.frames().queue().size())));
    bench.drain();
    EXPECT_LT(bench.expect_frames_sent(), 20);
  });
}

// A lane that is dead: it is told, no beat comes, and the other lanes are aligned. When it lives again, frames come.
TEST(LvdsSensor, ALaneThatNeverTrainsIsTold) {
  for_cases(6, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Vsp_lvds_codes> bench(seed, kCodes, 1000, 700);
    disturb(bench, kCodes);
    const auto lane = static_cast<std::size_t>(random.between(0, kCodes.lanes));
    bench.dead[lane] = true;
    EXPECT_FALSE(bench.wait_aligned(2 * training_words(kCodes)));
    EXPECT_EQ(bench.failed(), 1U << lane);
    bench.send(4, 4, 2, 20);
    bench.drain();
    EXPECT_TRUE(bench.beats().empty());
    bench.may_break().back() = true;
    bench.dead[lane] = false;
    ASSERT_TRUE(bench.wait_aligned(2 * training_words(kCodes)));
    EXPECT_EQ(bench.failed(), 0U);
    bench.send(4, 4, 2, 20);
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 1);
  });
}

// A board that is too slow, with a clock `slower` than that of the words: each frame comes whole, or it is the
// beginning of one, and counted.
template <typename Dut>
void expect_overruns_counted(const LvdsFormat& format, int slower, int rows, int min_gap, int max_gap) {
  int cut = 0;
  int whole = 0;
  for_cases(3, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000, 1000 * slower);
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    for (int frame = 0; frame < 30; ++frame) {
      bench.send(random.between(2, rows), 0, 1, random.between(min_gap, max_gap));
      bench.may_break().back() = true;
    }
    bench.set_beats_waiting(8000);
    bench.drain();
    const int lost = bench.expect_frames_sent();
    EXPECT_EQ(bench.overruns(), lost);
    EXPECT_EQ(bench.cuts() + bench.losses(), 0);
    cut += lost;
    whole += static_cast<int>(bench.sent().size()) - lost;
  });
  if (runs_all_cases()) {
    EXPECT_GT(cut, 10);
    EXPECT_GT(whole, 10);
  }
}
TEST(LvdsSensor, AFrameThatIsTooFastIsCutOffAndCounted) {
  expect_overruns_counted<Vsp_lvds_sensor>(kSixteen, 1, 60, 4, 1500);
}
TEST(LvdsSensor, AFrameOfOneLaneThatIsTooFastIsCutOffAndCounted) {
  expect_overruns_counted<Vsp_lvds_sensor_one>(kOne, 20, 300, 200, 9000);
}

// A board that takes nothing before the frame has ended: a frame of as many groups as the FIFO has places comes whole,
// and of a longer one just as many groups.
template <typename Dut>
void expect_places(const LvdsFormat& format) {
  constexpr int kPlaces = 512;
  const int groups = format.columns * format.lanes / std::max(format.lanes, 4);  // of a row
  for_cases(2, [&](std::uint64_t seed) {
    LvdsBench<Dut> bench(seed, format, 1000, 5'000'000);
    ASSERT_TRUE(bench.wait_aligned(training_words(format)));
    for (const int rows : {kPlaces / groups, kPlaces / groups + 1}) {
      bench.board_clocks(2);
      bench.send(rows, 0, 1, 20);
      bench.may_break().back() = rows * groups > kPlaces;
      while (!bench.frames().queue().empty()) {
        bench.step();
      }
      bench.words_in(60);
      bench.stopped = true;  // the sensor's clock, so that the rest takes no time
      bench.board_clocks(700);
      bench.stopped = false;
      bench.words_in(100);
      EXPECT_EQ(bench.overruns(), rows * groups > kPlaces ? 1 : 0);
      EXPECT_EQ(bench.expect_frames_sent(), bench.overruns());
      EXPECT_EQ(bench.beats().size(), static_cast<std::size_t>(std::min(rows * groups, kPlaces)));
      bench.forget();
    }
  });
}
TEST(LvdsSensor, TheFifoHoldsAsManyGroupsAsItHasPlaces) { expect_places<Vsp_lvds_sensor_four>(kFour); }
TEST(LvdsSensor, TheFifoOfOneLaneHoldsAsManyGroupsAsItHasPlaces) { expect_places<Vsp_lvds_sensor_one>(kOne); }

// A reset within a frame: everything is trained anew, and the next frame is the first.
TEST(LvdsSensor, AfterAResetTheNextFrameIsTheFirst) {
  for_cases(6, [&](Random& random, std::uint64_t seed) {
    LvdsBench<Vsp_lvds_sensor_one> bench(seed, kOne, 1000, 700);
    disturb(bench, kOne);
    ASSERT_TRUE(bench.wait_aligned(training_words(kOne)));
    bench.send(5, 0, 2, 40);
    bench.may_break().back() = true;
    bench.words_in(random.between(1, 100));
    bench.reset();
    bench.drain();
    ASSERT_TRUE(bench.wait_aligned(training_words(kOne)));
    bench.send(5, 0, 2, 40);
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 1);
    EXPECT_EQ(bench.cuts() + bench.losses() + bench.overruns(), 0);
  });
}

}  // namespace
}  // namespace selfproj::test
