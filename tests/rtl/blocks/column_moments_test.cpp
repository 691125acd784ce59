// Compares the column moments of the RTL with the model, beat by beat.
#include <gtest/gtest.h>

#include <cstdint>

#include "Vsp_column_moments_ports.h"
#include "Vsp_column_moments_small_ports.h"
#include "host/files/results_file.h"
#include "tests/rtl/blocks/column_moments_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::moments {

template <>
constexpr int kBinaryDelay<Vsp_column_moments_small> = 8;

namespace {

TEST(ColumnMoments, SmallSizes) { small_sizes<Vsp_column_moments>(kModes); }
TEST(ColumnMomentsSmall, SmallSizes) { small_sizes<Vsp_column_moments_small>({model::Mode::binary}); }

TEST(ColumnMoments, LargestImage) { large_size<Vsp_column_moments>(2048, 1023, kModes); }
TEST(ColumnMoments, TallestImageOfOneGroup) { large_size<Vsp_column_moments>(4, 1023, kModes); }
TEST(ColumnMoments, TallestImageOfTwoGroups) { large_size<Vsp_column_moments>(8, 1023, kModes); }
TEST(ColumnMoments, OriginalImage) { large_size<Vsp_column_moments>(512, 96, kModes); }
TEST(ColumnMomentsSmall, LargestImage) { large_size<Vsp_column_moments_small>(512, 127, {model::Mode::binary}); }
TEST(ColumnMomentsSmall, TallestImageOfOneGroup) {
  large_size<Vsp_column_moments_small>(4, 127, {model::Mode::binary});
}

// As the documents state them. Results: those of the original's 512 columns.
TEST(ColumnMoments, DelayIs10ClocksInBinaryAndGroupsAnd16InTheGreyModes) {
  for (const model::Mode mode : kModes) {
    for (const int columns : {4, 8, 12, 96, 512, 2048}) {
      EXPECT_EQ(delay_of<Vsp_column_moments>(columns, mode), mode == model::Mode::binary ? 10 : columns / 4 + 16)
          << columns << " columns";
    }
  }
  for (const int columns : {4, 8, 12, 96, 512}) {
    EXPECT_EQ(delay_of<Vsp_column_moments_small>(columns, model::Mode::binary), 8) << columns << " columns";
  }
  files::write_results("moments_delay",
                       "Clocks from a column's last pixel to its moments, at the ports of sp_column_moments",
                       {{"binary_build", delay_of<Vsp_column_moments_small>(512, model::Mode::binary)},
                        {"grey_build_binary", delay_of<Vsp_column_moments>(512, model::Mode::binary)},
                        {"grey_build_grey", delay_of<Vsp_column_moments>(512, model::Mode::grey)}});
}

TEST(ColumnMoments, RandomFramesOfOneSize) {
  for_cases(150, [&](Random& random) { random_frames<Vsp_column_moments>(random, kModes, 64, 9, false); });
}
TEST(ColumnMoments, RandomFramesOfChangingSizeAndMode) {
  for_cases(300, [&](Random& random) {
    random_frames<Vsp_column_moments>(random, kModes, random.chance(50) ? 64 : 400, 9, true);
  });
}
TEST(ColumnMomentsSmall, RandomFrames) {
  for_cases(150, [&](Random& random) {
    random_frames<Vsp_column_moments_small>(random, {model::Mode::binary}, 64, 9, random.chance(50));
  });
}

TEST(ColumnMoments, ASpoiledFrameSaysSo) { spoiled_frame<Vsp_column_moments>(); }

}  // namespace
}  // namespace selfproj::test::moments
