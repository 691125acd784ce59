// Compares the strongest runs of the RTL with the model, beat by beat.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "Vsp_column_runs_ports.h"
#include "Vsp_column_runs_small_ports.h"
#include "tests/rtl/blocks/column_moments_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::moments {

template <>
constexpr bool kBinaryDrains<Vsp_column_runs> = true;
template <>
constexpr int kBinaryDelay<Vsp_column_runs_small> = 12;

namespace {

TEST(ColumnRuns, SmallSizes) { small_sizes<Vsp_column_runs>(kModes); }
TEST(ColumnRunsSmall, SmallSizes) { small_sizes<Vsp_column_runs_small>({model::Mode::binary}); }

TEST(ColumnRuns, LargestImage) { large_size<Vsp_column_runs>(2048, 1023, {model::Mode::grey}); }
TEST(ColumnRuns, TallestImageOfOneGroup) { large_size<Vsp_column_runs>(4, 1023, kModes); }
TEST(ColumnRuns, TallestImageOfTwoGroups) { large_size<Vsp_column_runs>(8, 1023, kModes); }
TEST(ColumnRunsSmall, LargestImage) { large_size<Vsp_column_runs_small>(512, 127, {model::Mode::binary}); }
TEST(ColumnRunsSmall, TallestImageOfOneGroup) { large_size<Vsp_column_runs_small>(4, 127, {model::Mode::binary}); }
TEST(ColumnRunsSmall, TallestImageOfTwoGroups) { large_size<Vsp_column_runs_small>(8, 127, {model::Mode::binary}); }

// A column of long runs: two whose strengths are about sixteenths of each other, or some that end anywhere. Returns
// which rows are lit.
std::vector<bool> long_runs(Random& random, int rows) {
  std::vector<bool> lit(static_cast<std::size_t>(rows));
  int row = random.chance(50) ? 0 : random.between(0, rows / 8);
  const auto run = [&](int length) {
    for (const int end = std::min(rows, row + length); row < end; ++row) {
      lit[static_cast<std::size_t>(row)] = true;
    }
    row += 4;  // ends it, whatever the gap
  };
  if (random.chance(50)) {
    const int strong = random.between(rows / 4, 7 * rows / 8);
    const int second = strong * random.between(1, 16) / 16 + random.between(-1, 1);
    const bool strong_first = random.chance(50);
    run(strong_first ? strong : second);
    run(strong_first ? second : strong);
  } else {
    while (row < rows) {
      run(random.between(1, random.chance(50) ? rows / 2 : 20));
      row += random.between(0, rows / 8);
    }
  }
  return lit;
}

// The tallest images: large sums and rows are kept, compared, divided and forwarded.
template <typename Dut>
void tall_runs(int cases, int max_rows, const std::vector<model::Mode>& modes) {
  for_cases(cases, [&](Random& random, std::uint64_t seed) {
    const int columns = 4 * random.between(1, 5);
    const int rows = random.chance(50) ? max_rows : random.between(max_rows / 2, max_rows);
    Frame frame = random_frame<Dut>(random, columns, rows, modes[seed % modes.size()]);
    frame.select = model::Select::strongest;
    frame.gap = random.between(0, 3);
    frame.threshold = random.between(0, 100);
    frame.window = {};
    const bool bright = random.chance(70);
    for (int column = 0; column < columns; ++column) {
      const std::vector<bool> lit = long_runs(random, rows);
      for (int row = 0; row < rows; ++row) {
        const int value = bright ? 255 : random.between(frame.threshold + 1, 255);
        frame.pixels[static_cast<std::size_t>(row * columns + column)] =
            static_cast<std::uint8_t>(lit[static_cast<std::size_t>(row)] ? value : random.between(0, frame.threshold));
      }
    }
    ColumnBench<Dut> bench(random);
    bench.play(frame);
    bench.finish();
    ASSERT_FALSE(::testing::Test::HasFailure());
    EXPECT_EQ(bench.frames_accepted, 1);
  });
}
TEST(ColumnRuns, TallImagesOfLongRuns) { tall_runs<Vsp_column_runs>(60, 1023, kModes); }
TEST(ColumnRunsSmall, TallImagesOfLongRuns) { tall_runs<Vsp_column_runs_small>(60, 127, {model::Mode::binary}); }

// As the documents state them
TEST(ColumnRuns, DelayIsGroupsAnd19Clocks) {
  for (const model::Mode mode : kModes) {
    for (const int columns : {4, 8, 12, 96, 512, 2048}) {
      EXPECT_EQ(delay_of<Vsp_column_runs>(columns, mode), columns / 4 + 19) << columns << " columns";
    }
  }
}
TEST(ColumnRunsSmall, DelayIs12Clocks) {
  for (const int columns : {4, 8, 12, 512}) {
    EXPECT_EQ(delay_of<Vsp_column_runs_small>(columns, model::Mode::binary), 12) << columns << " columns";
  }
}

TEST(ColumnRuns, RandomFramesOfOneSize) {
  for_cases(150, [&](Random& random) {
    random_frames<Vsp_column_runs>(random, kModes, random.chance(60) ? 12 : 64, 12, false);
  });
}
TEST(ColumnRuns, RandomFramesOfChangingSizeAndMode) {
  for_cases(200, [&](Random& random) {
    random_frames<Vsp_column_runs>(random, kModes, random.chance(50) ? 64 : 400, 12, true);
  });
}
TEST(ColumnRunsSmall, RandomFrames) {
  for_cases(200, [&](Random& random) {
    random_frames<Vsp_column_runs_small>(random, {model::Mode::binary}, random.chance(60) ? 12 : 64, 12,
                                         random.chance(50));
  });
}

TEST(ColumnRuns, ASpoiledFrameSaysSo) { spoiled_frame<Vsp_column_runs>(); }

}  // namespace
}  // namespace selfproj::test::moments
