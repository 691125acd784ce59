// Compares the board with the Gray-code decoder, with and without the median, with the model, packet by packet and byte
// by byte.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "Vboard_codes.h"
#include "Vboard_codes_raw.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/random_codes.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr std::uint8_t kCodes = spec::kKindCodes;

template <class Model>
void play_all(int cases, bool full_build, int fault_percent) {
  CodeCounts counts;
  for_cases(cases, [&](std::uint64_t seed) { play_random_sequences<Model>(seed, full_build, fault_percent, counts); });
  std::printf("%llu frames, %llu lines of codes delivered, %llu lost; %llu frames abandoned\n",
              static_cast<unsigned long long>(counts.frames), static_cast<unsigned long long>(counts.delivered),
              static_cast<unsigned long long>(counts.lost), static_cast<unsigned long long>(counts.abandoned));
  if (runs_all_cases()) {
    EXPECT_GT(counts.delivered, counts.frames / 4) << "too little of the decoder was seen";
    EXPECT_GT(counts.lost, 0U) << "losses were not seen";
    EXPECT_GT(counts.abandoned, 0U) << "no frame was too close";
  }
}

TEST(CodesBoard, RandomSequencesEqualTheModel) { play_all<Vboard_codes>(40, true, 0); }
TEST(CodesBoard, RandomFaultsEqualTheModel) { play_all<Vboard_codes>(30, true, 10); }
TEST(RawCodesBoard, RandomSequencesEqualTheModel) { play_all<Vboard_codes_raw>(40, false, 0); }
TEST(RawCodesBoard, RandomFaultsEqualTheModel) { play_all<Vboard_codes_raw>(30, false, 10); }

// The longest code: all bits, after 24 patterns, in the largest images and in lower ones.
TEST(CodesBoard, LongestCodeEqualsTheModel) {
  Random random(2);
  Scoreboard<Vboard_codes> board({.bus_period_ps = 6000});
  board.count_patterns_on_frames(23);
  std::uint64_t lines = 0;
  for (const int rows : {kMaxCodeRows, 31, kMaxCodeRows}) {
    board.write({.columns = kMaxCodeColumns,
                 .rows = rows,
                 .mode = model::Mode::grey,
                 .threshold = 20,
                 .codes = true,
                 .median = rows == 31,
                 .code_bits = 12,
                 .code_threshold = 40});
    for (int frame = 0; frame < 2 * 24; ++frame) {
      const TestImage image = {rows, kMaxCodeColumns, random.bytes(static_cast<std::size_t>(rows * kMaxCodeColumns))};
      board.device().send(image.view());
      board.device().gap(120);
    }
    board.play();
    board.device().run(400);
    lines += 13U * static_cast<unsigned>(rows);  // 24 pairs less 11
  }
  board.finish();
  EXPECT_EQ(board.delivered(kCodes) + board.lost(kCodes), lines);
  // If such short lines follow each other without a gap, every other one is lost.
  EXPECT_GE(board.delivered(kCodes), lines / 2);
}

// The pattern index in the headers, up to its last value and past the wrap.
TEST(CodesBoard, PatternIndexCountsTo255) {
  Random random(3);
  Scoreboard<Vboard_codes> board;
  board.count_patterns_on_frames(255);
  board.write({.image = true, .columns = 8, .rows = 2});
  for (int frame = 0; frame < 600; ++frame) {
    board.device().send(random_image(random, 2, 8).view());
    board.device().gap(40);
  }
  board.finish();
  EXPECT_EQ(board.delivered(spec::kKindMoments), 600U);
  EXPECT_EQ(board.last_header(spec::kKindMoments).pattern, 599 % 256);
}

// Lines of codes of 88 columns and more may follow each other without a gap. Narrower lines are lost and counted.
TEST(RawCodesBoard, LinesNeedNoGap) {
  Random random(1);
  for (const int columns : {84, 88, 92, 128}) {
    Scoreboard<Vboard_codes_raw> board({.bus_period_ps = 6000}, false);
    board.count_patterns_on_frames(7);
    board.write({.columns = columns, .rows = 40, .codes = true, .code_bits = 4});
    for (int frame = 0; frame < 24; ++frame) {
      board.device().send(random_image(random, 40, columns).view());
    }
    board.finish();
    EXPECT_EQ(board.delivered(kCodes) + board.lost(kCodes), 9U * 40U) << columns;  // 12 pairs less 3
    EXPECT_EQ(board.lost(kCodes) == 0, columns >= 88) << columns;
  }
}

// The bus stands still. The FIFO takes lines until it is full and no further; all lines that it took come out whole.
TEST(CodesBoard, FifoFillsToTheLastPlace) {
  constexpr std::size_t kPlaces = 512;
  Random random(4);
  for (const int columns : {4, 12, 40, 64}) {
    SCOPED_TRACE(::testing::Message() << columns << " columns");
    Scoreboard<Vboard_codes> board({.bus_period_ps = 6000});
    board.count_patterns_on_frames(1);
    board.write({.columns = columns, .rows = 8, .codes = true, .code_bits = 1, .code_threshold = 9});
    board.device().set_bus_stall_percent(100);
    for (int frame = 0; frame < 2 * 120; ++frame) {
      board.device().send(random_image(random, 8, columns).view());
      board.device().gap(120);
    }
    board.play();
    board.device().run(400);
    const unsigned lines = 120 * 8 - board.device().read(spec::kRegLostCodes);
    board.device().set_bus_stall_percent(0);
    board.finish();
    EXPECT_EQ(board.delivered(kCodes), lines);
    const std::size_t beats = packet_beats(model::codes_line_payload_bytes(columns));
    EXPECT_GT((lines + 1) * beats, kPlaces);
    EXPECT_LE(lines * beats, kPlaces + 8);
  }
}

// The registers say what this build can do, and refuse what it cannot.
TEST(CodesBoard, SaysWhatItIsAndRefusesTheRest) {
  sim::BoardDevice<Vboard_codes> full;
  EXPECT_EQ(full.read(spec::kRegCapability) >> spec::kRegCapabilityCodesLsb & 3U, 3U);
  EXPECT_EQ(full.read(spec::kRegCapability) >> spec::kRegCapabilityCodeBitsLsb, 12U);
  EXPECT_EQ(full.read(spec::kRegDecode), spec::kRegDecodeReset);
  sim::BoardDevice<Vboard_codes_raw> raw;
  EXPECT_EQ(raw.read(spec::kRegCapability) >> spec::kRegCapabilityCodesLsb & 3U, 1U);
  EXPECT_EQ(raw.read(spec::kRegCapability) >> spec::kRegCapabilityCodeBitsLsb, 8U);
  constexpr std::uint32_t kMedian = 1U << spec::kRegDecodeMedianLsb;
  const auto bits = [](std::uint32_t m) { return m << spec::kRegDecodeBitsLsb; };
  EXPECT_TRUE(full.access(true, spec::kRegDecode, bits(0)).error);
  EXPECT_TRUE(full.access(true, spec::kRegDecode, bits(13)).error);
  EXPECT_FALSE(full.access(true, spec::kRegDecode, bits(12) | kMedian).error);
  EXPECT_EQ(full.read(spec::kRegDecode), bits(12) | kMedian);
  EXPECT_TRUE(raw.access(true, spec::kRegDecode, bits(9)).error);
  EXPECT_TRUE(raw.access(true, spec::kRegDecode, bits(8) | kMedian).error);
  EXPECT_FALSE(raw.access(true, spec::kRegDecode, bits(8) | 77U).error);
  EXPECT_EQ(raw.read(spec::kRegDecode), bits(8) | 77U);
}

}  // namespace
}  // namespace selfproj::test
