// Compares the board with the strongest runs, of the grey modes and binary, with the model, byte by byte.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

#include "Vboard_codes.h"
#include "Vboard_codes_raw.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(RunsBoard, RandomSmallFramesEqualTheModel) { play_all_random_frames<Vboard_codes>(15, {.runs = true}, 3); }
TEST(RunsBoard, RandomFaultsEqualTheModel) {
  play_all_random_frames<Vboard_codes>(10, {.runs = true, .fault_percent = 40}, 3);
}
TEST(CompactBoard, RandomSmallFramesEqualTheModel) {
  play_all_random_frames<Vboard_codes>(15, {.runs = true, .compact = true}, 4);
}
TEST(CompactBoard, RandomFaultsEqualTheModel) {
  play_all_random_frames<Vboard_codes>(10, {.runs = true, .compact = true, .fault_percent = 40}, 4);
}
TEST(BinaryRunsBoard, RandomSmallFramesEqualTheModel) {
  play_all_random_frames<Vboard_codes_raw>(15, {.max_columns = 128, .grey = false, .image = false, .runs = true}, 3);
}
TEST(BinaryRunsBoard, RandomFaultsEqualTheModel) {
  play_all_random_frames<Vboard_codes_raw>(10, {.grey = false, .image = false, .runs = true, .fault_percent = 40}, 3);
}

// An image with two long bright runs in each column, the second of which may end with the frame.
TestImage two_runs_image(Random& random, int rows, int columns, int gap) {
  TestImage image = constant_image(rows, columns, 0);
  for (int column = 0; column < columns; ++column) {
    const int first = random.between(1, rows);
    const int second = first + gap + 1;
    const int end = random.chance(50) ? rows : random.between(1, rows);
    for (int row = 0; row < rows; ++row) {
      const bool lit = row < first || (row >= second && row < end);
      image.pixels[static_cast<std::size_t>(row * columns + column)] = lit ? 255 : 0;
    }
  }
  return image;
}

// The tallest frames: large sums and rows, and second runs nearly as strong as the strongest.
TEST(RunsBoard, TallFramesOfTwoLongRuns) {
  constexpr int kColumns = 64;
  constexpr int kRows = 40;
  constexpr int kFrames = 4;  // of equal settings
  Random random(1);
  Scoreboard<Vboard_codes> board;
  std::uint64_t frames = 0;
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    for (int gap = 0; gap < 4; ++gap) {
      board.write({.columns = kColumns,
                   .rows = kRows,
                   .mode = mode,
                   .threshold = random.between(0, 8),
                   .select = model::Select::strongest,
                   .gap = gap});
      for (int i = 0; i < kFrames; ++i, ++frames) {
        board.device().send(two_runs_image(random, kRows, kColumns, gap).view());
        board.device().gap(200);
      }
      board.play();
    }
  }
  board.finish();
  EXPECT_EQ(board.delivered(spec::kKindMoments), frames);
}

// The packets lost of 20 frames of equal settings with so many clocks after the last beat of each.
template <class Model>
std::uint64_t lost_at(model::Mode mode, int columns, int rows, int gap, bool compact = false) {
  Random random(1);
  Scoreboard<Model> board({.bus_period_ps = 4000});
  board.write({.columns = columns,
               .rows = rows,
               .mode = mode,
               .select = model::Select::strongest,
               .gap = 1,
               .compact = compact});
  for (int i = 0; i < 20; ++i) {
    board.device().send(random_image(random, rows, columns).view());
    board.device().gap(static_cast<std::uint32_t>(gap));
  }
  board.finish();
  return board.lost(spec::kKindMoments);
}

// docs/using-the-circuits.md states these distances between frame starts.
TEST(RunsBoard, FramesAtTheSmallestDistanceAreDelivered) {
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    for (const int groups : {1, 2, 3, 5, 16}) {
      const int distance = 2 * groups + 22;
      EXPECT_EQ(lost_at<Vboard_codes>(mode, 4 * groups, 1, distance - groups), 0U) << groups << " groups";
      EXPECT_GT(lost_at<Vboard_codes>(mode, 4 * groups, 1, distance - groups - 1), 0U) << groups << " groups";
    }
  }
}
// Compact columns wait RowBits + 12 clocks more; two beats of exact ones are one of theirs.
TEST(CompactBoard, FramesAtTheSmallestDistanceAreDelivered) {
  constexpr int kRowBits = 6;  // of up to 40 rows
  for (const int groups : {1, 2, 3, 5, 16}) {
    const int distance = 2 * groups + 22 + kRowBits + 12;
    EXPECT_EQ(lost_at<Vboard_codes>(model::Mode::grey, 4 * groups, 1, distance - groups, true), 0U) << groups;
    EXPECT_GT(lost_at<Vboard_codes>(model::Mode::grey, 4 * groups, 1, distance - groups - 1, true), 0U) << groups;
  }
}
TEST(BinaryRunsBoard, FramesAtTheSmallestDistanceAreDelivered) {
  for (const int groups : {1, 2, 3, 5, 32}) {
    const int distance = groups + 15;
    EXPECT_EQ(lost_at<Vboard_codes_raw>(model::Mode::binary, 4 * groups, 1, distance - groups), 0U)
        << groups << " groups";
    EXPECT_GT(lost_at<Vboard_codes_raw>(model::Mode::binary, 4 * groups, 1, distance - groups - 1), 0U)
        << groups << " groups";
  }
}

}  // namespace
}  // namespace selfproj::test
