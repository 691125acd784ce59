// Compares the column moments of pixels of 10 and 12 bits with the model, beat by beat.
#include <gtest/gtest.h>

#include <vector>

#include "Vsp_column_moments_ten_ports.h"
#include "Vsp_column_moments_twelve_ports.h"
#include "Vsp_column_moments_twelve_small_ports.h"
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

TEST(WideMoments, ASpoiledFrameSaysSo) { spoiled_frame<Vsp_column_moments_twelve>(); }

}  // namespace
}  // namespace selfproj::test::moments
