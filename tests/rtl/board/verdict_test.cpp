// Compares the board with verdicts with the model: packets with a verdict, or with nothing but it, registers, and the
// pin for an ejector.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <utility>

#include "Vboard_verdict.h"
#include "Vboard_verdict_binary.h"
#include "tests/rtl/board/verdict_board.h"

namespace selfproj::test {

namespace {

TEST(VerdictBoard, RandomFramesEqualTheModel) {
  constexpr int kCases = 4;
  VerdictCounts seen;
  for_cases(kCases, [&](std::uint64_t seed) { play_verdicts<Vboard_verdict>(seed, 0, 40, seen); });
  if (runs_all_cases()) {
    EXPECT_GT(seen.delivered, seen.frames / 2);
    EXPECT_GT(seen.lost, 0U);
    EXPECT_GT(seen.parts, 10U * kCases);
    EXPECT_GT(seen.bad, kCases);
    EXPECT_GT(seen.refused, kCases);
  }
}

TEST(VerdictBoard, RandomFaultsEqualTheModel) {
  VerdictCounts seen;
  for_cases(3, [&](std::uint64_t seed) { play_verdicts<Vboard_verdict>(seed, 30, 40, seen); });
  if (runs_all_cases()) {
    EXPECT_GT(seen.delivered, seen.frames / 2);
    EXPECT_GT(seen.bad, 3U);
  }
}

// One column after the other has a limit at its centroid, rounded up or down, and all others may lie anywhere.
TEST(VerdictBoard, LimitsCountToTheLastBit) {
  constexpr int kColumns = 64, kRows = 17;
  const model::ColumnLimits wide = {.low = 0, .high = model::kRowParts * 40, .judged = true};
  VerdictBoard<Vboard_verdict> bench;
  Random random(1);
  bench.write(spec::kRegEjectorDelay, 0);
  bench.write(spec::kRegEjectorLength, 1);
  for (int column = 0; column < kColumns; ++column) {
    bench.write_limits(0, 0, column, wide);
  }
  bench.begin_section(0, 1, model::kCountMask);  // never
  model::BoardSettings settings = {.columns = kColumns,
                                   .rows = kRows,
                                   .mode = model::Mode::binary,
                                   .threshold = 100,
                                   .verdict = true,
                                   .verdict_packets = 1,
                                   .verdict_settings = {.width = 1, .history = 1, .hits = 1},
                                   .part_rule = {.by_encoder = true, .length = 1000, .pitch = 2000}};
  std::uint64_t out = 0, good = 0, bad_parts = 0;
  for (int i = 0; i < 4 * kColumns && !HasFailure(); ++i) {
    const int column = i % kColumns;
    const TestImage image = random_image(random, kRows, kColumns);
    model::Moments moments;
    moments.resize(kColumns);
    model::column_moments(image.view(), settings.mode, settings.threshold, moments.view());
    const auto at = static_cast<std::size_t>(column);
    const std::uint32_t low = model::kRowParts * moments.m1[at] / std::max(1U, moments.m0[at]);
    model::ColumnLimits limits = wide;
    (i < 2 * kColumns ? limits.low : limits.high) = low + static_cast<std::uint32_t>(random.between(0, 1));
    settings.verdict = false;
    bench.write(settings);
    bench.device().send(constant_image(kRows, kColumns, 0).view());
    bench.board().play();
    bench.write_limits(0, 0, (column + kColumns - 1) % kColumns, wide);
    bench.write_limits(0, 0, column, limits);
    settings.verdict = true;
    bench.write(settings);
    bench.device().send(image.view());
    bench.board().play();
    (bench.verdict().bad_parts() > bad_parts ? out : good) += 1;
    bad_parts = bench.verdict().bad_parts();
  }
  bench.board().finish();
  EXPECT_GT(out, 50U);
  EXPECT_GT(good, 50U);
}

// The columns of a frame of which only the verdict is sent have not left when a frame of one row follows, which is not
// judged and for which there is no room.
TEST(VerdictBoard, AFrameThatIsNotWantedChangesNoPacket) {
  constexpr int kColumns = 64;
  VerdictBoard<Vboard_verdict> bench;
  bench.write(spec::kRegEjectorDelay, 0);
  bench.write(spec::kRegEjectorLength, 1);
  model::BoardSettings settings = {.columns = kColumns,
                                   .rows = 40,
                                   .mode = model::Mode::grey,
                                   .threshold = 100,
                                   .verdict = true,
                                   .verdict_packets = 2,
                                   .verdict_settings = {.width = 1, .history = 1, .hits = 1},
                                   .part_rule = {.by_encoder = true, .length = 1000, .pitch = 2000}};
  for (int i = 0; i < 10; ++i) {
    settings.rows = 40;
    settings.verdict = true;
    bench.write(settings);
    bench.device().send(constant_image(settings.rows, kColumns, 200).view());
    bench.device().send(constant_image(1, kColumns, 200).view());
    bench.device().run(20 + static_cast<std::uint64_t>(i));
    settings.rows = 1;
    settings.verdict = false;
    bench.write(settings);
    bench.board().play();
    bench.device().drain(kApart);
  }
  bench.board().finish();
  EXPECT_EQ(bench.board().delivered(spec::kKindMoments), 10U);
  EXPECT_EQ(bench.board().lost(spec::kKindMoments), 10U);
}

TEST(VerdictBoard, FramesOfSoManyRowsAreJudgedAtFullRate) {
  constexpr int kFrames = 10;
  for (const auto& [rows, missed] : {std::pair{2, kFrames}, {5, kFrames}, {6, 0}, {7, 0}}) {
    EXPECT_EQ(missed_frames<Vboard_verdict_binary>(512, rows, model::Mode::binary, kFrames), missed) << rows << " rows";
  }
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey}) {
    for (const auto& [rows, missed] : {std::pair{3, kFrames}, {6, kFrames}, {10, 0}}) {
      EXPECT_EQ(missed_frames<Vboard_verdict>(64, rows, mode, kFrames), missed) << rows << " rows";
    }
  }
}

TEST(VerdictBoard, ThePinFollowsWithinAMicrosecond) {
  constexpr double kClocksOfAMicrosecond = 151.2;
  const int binary = clocks_to_the_pin<Vboard_verdict_binary>(512, model::Mode::binary);
  EXPECT_LE(binary, kClocksOfAMicrosecond);
  EXPECT_EQ(binary, 29);
  // Columns leave two a clock, while their row comes four a clock.
  EXPECT_EQ(clocks_to_the_pin<Vboard_verdict>(64, model::Mode::grey), 56);
}

}  // namespace
}  // namespace selfproj::test
