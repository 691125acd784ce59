// Compares the column moments of pixels of 10 and 12 bits, and those of 8 and 16 pixels a clock with their strongest
// runs, with the model, beat by beat.
#include <gtest/gtest.h>

#include <vector>

#include "Vsp_column_moments_eight_of_twelve_ports.h"
#include "Vsp_column_moments_eight_ports.h"
#include "Vsp_column_moments_sixteen_ports.h"
#include "Vsp_column_moments_sixteen_small_ports.h"
#include "Vsp_column_moments_ten_ports.h"
#include "Vsp_column_moments_twelve_ports.h"
#include "Vsp_column_moments_twelve_small_ports.h"
#include "Vsp_column_runs_eight_ports.h"
#include "Vsp_column_runs_eight_small_ports.h"
#include "Vsp_column_runs_sixteen_ports.h"
#include "Vsp_column_runs_ten_of_eight_ports.h"
#include "Vsp_column_runs_twelve_ports.h"
#include "tests/rtl/blocks/column_moments_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::moments {

template <>
constexpr int kPixelBits<Vsp_column_moments_ten> = 10;
template <>
constexpr int kPixelBits<Vsp_column_moments_twelve> = 12;
template <>
constexpr int kPixelBits<Vsp_column_moments_twelve_small> = 12;
template <>
constexpr int kBinaryDelay<Vsp_column_moments_twelve_small> = 8;

template <>
constexpr int kLanes<Vsp_column_moments_eight> = 8;
template <>
constexpr int kLanes<Vsp_column_moments_eight_of_twelve> = 8;
template <>
constexpr int kPixelBits<Vsp_column_moments_eight_of_twelve> = 12;
template <>
constexpr int kLanes<Vsp_column_moments_sixteen> = 16;
template <>
constexpr int kLanes<Vsp_column_moments_sixteen_small> = 16;
template <>
constexpr int kBinaryDelay<Vsp_column_moments_sixteen_small> = 8;
template <>
constexpr int kLanes<Vsp_column_runs_eight> = 8;
template <>
constexpr bool kBinaryDrains<Vsp_column_runs_eight> = true;
template <>
constexpr int kLanes<Vsp_column_runs_eight_small> = 8;
template <>
constexpr int kBinaryDelay<Vsp_column_runs_eight_small> = 12;
template <>
constexpr int kLanes<Vsp_column_runs_sixteen> = 16;
template <>
constexpr bool kBinaryDrains<Vsp_column_runs_sixteen> = true;
template <>
constexpr int kPixelBits<Vsp_column_runs_twelve> = 12;
template <>
constexpr bool kBinaryDrains<Vsp_column_runs_twelve> = true;
template <>
constexpr int kPixelBits<Vsp_column_runs_ten_of_eight> = 10;
template <>
constexpr int kLanes<Vsp_column_runs_ten_of_eight> = 8;
template <>
constexpr bool kBinaryDrains<Vsp_column_runs_ten_of_eight> = true;

namespace {

const std::vector<model::Mode> kBinaryAlone{model::Mode::binary};

TEST(WideMoments, SmallSizes) {
  small_sizes<Vsp_column_moments_ten>(kModes);
  small_sizes<Vsp_column_moments_twelve>(kModes);
  small_sizes<Vsp_column_moments_twelve_small>(kBinaryAlone);
}

TEST(WideMoments, LargestImages) {
  large_size<Vsp_column_moments_ten>(64, 1023, kModes);
  large_size<Vsp_column_moments_twelve>(2048, 1023, kModes);
  large_size<Vsp_column_moments_twelve>(4, 1023, kModes);
  large_size<Vsp_column_moments_twelve>(8, 1023, kModes);
  large_size<Vsp_column_moments_twelve_small>(512, 127, kBinaryAlone);
}

TEST(WideMoments, DelaysAreThoseOfEightBits) {
  for (const model::Mode mode : kModes) {
    EXPECT_EQ(delay_of<Vsp_column_moments_twelve>(512, mode), mode == model::Mode::binary ? 10 : 512 / 4 + 16);
  }
  EXPECT_EQ(delay_of<Vsp_column_moments_twelve_small>(512, model::Mode::binary), 8);
}

TEST(WideMoments, RandomFramesOfTenBits) {
  for_cases(150, [&](Random& random) {
    random_frames<Vsp_column_moments_ten>(random, kModes, random.chance(50) ? 64 : 400, 9, random.chance(50));
  });
}
TEST(WideMoments, RandomFramesOfTwelveBits) {
  for_cases(300, [&](Random& random) {
    random_frames<Vsp_column_moments_twelve>(random, kModes, random.chance(50) ? 64 : 400, 9, random.chance(50));
  });
}
TEST(WideMoments, RandomFramesOfABinaryBuild) {
  for_cases(150, [&](Random& random) {
    random_frames<Vsp_column_moments_twelve_small>(random, kBinaryAlone, 64, 9, random.chance(50));
  });
}

// 8 and 16 pixels a clock
TEST(WideBeats, SmallSizes) {
  small_sizes<Vsp_column_moments_eight>(kModes);
  small_sizes<Vsp_column_moments_eight_of_twelve>(kModes);
  small_sizes<Vsp_column_moments_sixteen>(kModes);
  small_sizes<Vsp_column_moments_sixteen_small>(kBinaryAlone);
  small_sizes<Vsp_column_runs_eight>(kModes);
  small_sizes<Vsp_column_runs_eight_small>(kBinaryAlone);
  small_sizes<Vsp_column_runs_sixteen>(kModes);
}

TEST(WideBeats, LargestImages) {
  large_size<Vsp_column_moments_eight>(2048, 1023, {model::Mode::grey_over});
  large_size<Vsp_column_moments_eight_of_twelve>(2048, 1023, {model::Mode::grey});
  large_size<Vsp_column_moments_sixteen>(2048, 1023, {model::Mode::grey});
  large_size<Vsp_column_runs_eight>(2048, 1023, {model::Mode::grey});
  large_size<Vsp_column_runs_sixteen>(2048, 1023, {model::Mode::grey_over});
  large_size<Vsp_column_runs_eight>(8, 1023, kModes);
  large_size<Vsp_column_runs_sixteen>(32, 1023, kModes);
}

TEST(WideBeats, DelaysAreGroupsAndThoseOfFourPixels) {
  for (const model::Mode mode : kModes) {
    const bool binary = mode == model::Mode::binary;
    EXPECT_EQ(delay_of<Vsp_column_moments_eight>(512, mode), binary ? 10 : 512 / 8 + 16);
    EXPECT_EQ(delay_of<Vsp_column_moments_sixteen>(512, mode), binary ? 10 : 512 / 16 + 16);
    EXPECT_EQ(delay_of<Vsp_column_runs_eight>(512, mode), 512 / 8 + 19);
    EXPECT_EQ(delay_of<Vsp_column_runs_sixteen>(512, mode), 512 / 16 + 19);
  }
}

template <typename Dut>
void many_random_frames(int cases, const std::vector<model::Mode>& modes) {
  for_cases(cases, [&](Random& random) {
    random_frames<Dut>(random, modes, random.chance(50) ? 4 * kLanes<Dut> : 400, 12, random.chance(50));
  });
}
TEST(WideBeats, RandomFrames) {
  many_random_frames<Vsp_column_moments_eight>(200, kModes);
  many_random_frames<Vsp_column_moments_eight_of_twelve>(100, kModes);
  many_random_frames<Vsp_column_moments_sixteen>(100, kModes);
  many_random_frames<Vsp_column_moments_sixteen_small>(100, kBinaryAlone);
  many_random_frames<Vsp_column_runs_eight>(200, kModes);
  many_random_frames<Vsp_column_runs_eight_small>(100, kBinaryAlone);
  many_random_frames<Vsp_column_runs_sixteen>(100, kModes);
}

TEST(WideBeats, ASpoiledFrameSaysSo) {
  spoiled_frame<Vsp_column_moments_eight>();
  spoiled_frame<Vsp_column_runs_eight>();
}

// Strongest runs of 12 and 10 bits
TEST(WideRuns, SmallSizes) {
  small_sizes<Vsp_column_runs_twelve>(kModes);
  small_sizes<Vsp_column_runs_ten_of_eight>(kModes);
}
TEST(WideRuns, LargestImages) {
  large_size<Vsp_column_runs_twelve>(2048, 1023, {model::Mode::grey});
  large_size<Vsp_column_runs_twelve>(4, 1023, kModes);
  large_size<Vsp_column_runs_ten_of_eight>(2048, 1023, {model::Mode::grey_over});
}
TEST(WideRuns, RandomFrames) {
  many_random_frames<Vsp_column_runs_twelve>(300, kModes);
  many_random_frames<Vsp_column_runs_ten_of_eight>(200, kModes);
}

TEST(WideMoments, ASpoiledFrameSaysSo) { spoiled_frame<Vsp_column_moments_twelve>(); }

}  // namespace
}  // namespace selfproj::test::moments
