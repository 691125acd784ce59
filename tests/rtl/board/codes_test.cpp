// The board with the Gray-code decoder against the model, packet by packet and byte by byte: with the median and
// without.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "Vboard_codes.h"
#include "Vboard_codes_raw.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr std::uint8_t kCodes = spec::kKindCodes;
constexpr int kMaxColumns = 64;
constexpr int kMaxRows = 40;

struct CodeCounts {
  std::uint64_t frames = 0;
  std::uint64_t delivered = 0;  // lines of codes
  std::uint64_t lost = 0;
  std::uint64_t abandoned = 0;
  std::map<std::uint32_t, std::uint64_t> by_status;
};

// Sequences of frames of random size, m and content, whose settings change; with gaps or without, faults, and stalls on
// the bus. Every packet of every kind is compared with the model's; what is missing must be counted.
template <class Model>
void play_random_sequences(std::uint64_t seed, bool full_build, int fault_percent, CodeCounts& counts) {
  Random random(seed);
  Scoreboard<Model> board({.seed = seed,
                           .video_period_ps = static_cast<std::uint64_t>(random.between(5000, 9000)),
                           .bus_period_ps = static_cast<std::uint64_t>(random.between(3000, 12000)),
                           .bus_phase_ps = static_cast<std::uint64_t>(random.between(0, 5000))},
                          full_build);
  const int bits = random.between(1, 3);
  board.count_patterns_on_frames(2 * bits - 1);
  BoardSettings settings;
  for (int change = 0; change < 40 && !::testing::Test::HasFailure(); ++change) {
    if (change == 0 || random.chance(60)) {
      settings.columns = 4 * random.between(1, random.chance(50) ? 6 : kMaxColumns / 4);
      settings.rows = random.between(1, random.chance(60) ? 4 : kMaxRows / 4);
    }
    settings.image = full_build && random.chance(30);
    settings.mode = full_build ? static_cast<Mode>(random.between(0, 2)) : Mode::binary;
    settings.threshold = random.between(0, 255);
    settings.stream = random.between(0, 255);
    settings.timeout = random.chance(70) ? 0 : random.between(20, 200);
    settings.codes = random.chance(95);
    settings.median = full_build && random.chance(60);
    settings.code_bits = random.chance(90) ? bits : random.between(1, 8);
    settings.code_threshold = random.between(0, 60);
    board.write(settings);
    board.device().set_video_gap_percent(random.chance(40) ? 0 : random.between(0, 60));
    board.device().set_bus_stall_percent(random.chance(60) ? 0 : random.between(0, 95));
    const bool spaced = random.chance(70);
    for (int i = random.between(1, 20); i > 0; --i) {
      const TestImage image = random_image(random, settings.rows, settings.columns);
      const Fault fault =
          random.chance(fault_percent) ? static_cast<Fault>(random.between(0, kFaults - 1)) : Fault::none;
      for (const VideoBeat& beat : with_fault(lines_of(image), fault, random.between(0, settings.rows - 1),
                                              random.between(0, settings.columns / 4 - 1))) {
        board.device().send(beat);
        if (fault_percent != 0 && random.chance(1)) {
          board.device().gap(static_cast<std::uint32_t>(random.between(1, 250)));
        }
      }
      if (spaced) {
        board.device().gap(static_cast<std::uint32_t>(random.between(0, random.chance(50) ? 12 : 120)));
      }
    }
    board.play();
  }
  board.finish();
  counts.frames += board.model().frames();
  counts.delivered += board.delivered(kCodes);
  counts.lost += board.lost(kCodes);
  counts.abandoned += board.model().abandoned();
  for (const auto& [status, count] : board.by_status()) {
    counts.by_status[status] += count;
  }
}

template <class Model>
void play_all(int cases, bool full_build, int fault_percent) {
  CodeCounts counts;
  for (const std::uint64_t seed : seeds(cases)) {
    SCOPED_TRACE(how_to_repeat(seed));
    play_random_sequences<Model>(seed, full_build, fault_percent, counts);
    if (::testing::Test::HasFailure()) {
      return;
    }
  }
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

// Lines of codes of 88 columns and more follow each other without a gap; narrower ones are lost, and counted.
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

// What this build can do stands in its registers, and what it cannot is refused.
TEST(CodesBoard, SaysWhatItIsAndRefusesTheRest) {
  BoardDevice<Vboard_codes> full;
  EXPECT_EQ(full.read(spec::kRegCapability) >> spec::kRegCapabilityCodesLsb & 3U, 3U);
  EXPECT_EQ(full.read(spec::kRegCapability) >> spec::kRegCapabilityCodeBitsLsb, 12U);
  EXPECT_EQ(full.read(spec::kRegDecode), spec::kRegDecodeReset);
  BoardDevice<Vboard_codes_raw> raw;
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
