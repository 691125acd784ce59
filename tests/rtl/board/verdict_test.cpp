// Compares the board with verdicts with the model: packets with a verdict, or with nothing but it, registers, and the
// pin for an ejector.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <utility>

#include "Vboard_verdict_binary.h"
#include "tests/rtl/board/verdict_board.h"

namespace selfproj::test {

template <>
constexpr model::BoardBuild kBuild<Vboard_verdict_binary> = {
    .max_columns = 512, .max_rows = 127, .grey = false, .image = false, .verdict_log_sections = 0};

namespace {

TEST(VerdictBoard, RandomFramesEqualTheModel) {
  constexpr int kCases = 4;
  VerdictCounts seen;
  for_cases(kCases, [&](std::uint64_t seed) { play_verdicts(seed, 0, 40, seen); });
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
  for_cases(3, [&](std::uint64_t seed) { play_verdicts(seed, 30, 40, seen); });
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

// From the last pixels of the frame that has the first defect to the pin.
template <class Model>
int clocks_to_the_pin(int columns, model::Mode mode) {
  VerdictBoard<Model> bench;
  bench.write(spec::kRegEjectorDelay, 0);
  bench.write(spec::kRegEjectorLength, 1);
  for (int column = 0; column < columns; ++column) {
    bench.write_limits(0, 0, column, {.low = 3 * model::kRowParts, .high = 5 * model::kRowParts, .judged = true});
  }
  if (kBuild<Model>.verdict_log_sections > 0) {
    bench.begin_section(0, 1, model::kCountMask);  // never
  }
  bench.write({.columns = columns,
               .rows = 8,
               .mode = mode,
               .threshold = 100,
               .verdict = true,
               .verdict_packets = 1,
               .verdict_settings = {.width = 16, .history = 2, .hits = 2},
               .part_rule = {.by_encoder = true, .length = 1000, .pitch = 2000}});
  int clocks = -1;
  for (const int row : {4, 7, 7}) {  // good, the first hit, the second
    EXPECT_FALSE(bench.device().ejector());
    TestImage image = constant_image(8, columns, 0);
    std::fill_n(image.pixels.begin() + static_cast<std::ptrdiff_t>(row - 1) * columns, columns, std::uint8_t{200});
    bench.device().send(image.view());
    bench.board().play();
    for (clocks = 0; clocks < 300 && !bench.device().ejector(); ++clocks) {
      bench.device().run(1);
    }
  }
  bench.board().finish();
  EXPECT_EQ(bench.verdict().bad_parts(), 1U);
  return clocks;
}

// How many frames are missed, of so many without a pause between pixels or frames.
template <class Model>
std::uint32_t missed_frames(int columns, int rows, model::Mode mode, int frames) {
  VerdictBoard<Model> bench;
  bench.write(spec::kRegEjectorDelay, 0);
  bench.write(spec::kRegEjectorLength, 1);
  bench.write(
      {.columns = columns, .rows = rows, .mode = mode, .threshold = 100, .verdict = true, .verdict_packets = 2});
  const TestImage image = constant_image(rows, columns, 200);
  for (int i = 0; i < frames; ++i) {
    bench.device().send(image.view());
  }
  bench.device().drain(1000);
  const std::uint32_t state = bench.device().read(spec::kRegVerdictState);
  return state >> spec::kRegVerdictStateMissedLsb & ((1U << spec::kRegVerdictStateMissedBits) - 1);
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
