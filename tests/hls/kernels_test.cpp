// Tests the HLS kernels against the model. Built once with SystemC's integers, once with memories that show writes
// late, and once with the vendor's integers if they are available.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "tests/hls/gray_kernel_bench.h"
#include "tests/hls/moments_bench.h"

namespace selfproj::test {
namespace {

MomentsBench::Step moments_kernel() {
  return [kernel = std::make_shared<hls::ColumnMomentsKernel>()](auto& video, const auto& setup, auto& payload) {
    kernel->step(video, setup, payload);
  };
}

MomentsBench::Step moments_top() {
  return [](auto& video, const auto& setup, auto& payload) {
    column_moments_top(video, setup.columns, setup.rows, setup.mode, setup.threshold, setup.first_row, setup.last_row,
                       payload);
  };
}

MomentsBench::Step runs_kernel() {
  return [kernel = std::make_shared<hls::ColumnRunsKernel>()](auto& video, const auto& setup, auto& payload) {
    kernel->step(video, setup, payload);
  };
}

MomentsBench::Step runs_top() {
  return [](auto& video, const auto& setup, auto& payload) {
    column_runs_top(video, setup.columns, setup.rows, setup.mode, setup.threshold, setup.strongest ? 1 : 0, setup.gap,
                    setup.first_row, setup.last_row, payload);
  };
}

GrayKernelBench::Step gray_kernel() {
  return [kernel = std::make_shared<hls::GrayDecoderKernel<64, 16>>()](
             auto& video, const auto& setup, auto pattern, auto& codes) { kernel->step(video, setup, pattern, codes); };
}

GrayKernelBench::Step gray_top() {
  return [](auto& video, const auto& setup, auto pattern, auto& codes) {
    gray_decoder_top(video, setup.columns, setup.rows, setup.bits, setup.threshold, setup.median ? 1 : 0, pattern,
                     codes);
  };
}

TEST(HlsColumnMoments, RandomFrames) {
  std::uint64_t matched = 0;
  for_cases(200, [&](Random& random) {
    // The kernel of the top function keeps its state from case to case.
    MomentsBench bench(random.chance(50) ? moments_kernel() : moments_top());
    play_moments_frames(bench, 40, random);
    ASSERT_FALSE(HasFailure());
    matched += bench.matched();
  });
  if (std::getenv("SELFPROJ_SEED") == nullptr) {
    EXPECT_GT(matched, 20'000U) << "too little was compared";
  }
}

TEST(HlsColumnRuns, RandomFrames) {
  std::uint64_t matched = 0;
  for_cases(200, [&](Random& random) {
    MomentsBench bench(random.chance(50) ? runs_kernel() : runs_top());
    play_moments_frames(bench, 40, random, true);
    ASSERT_FALSE(HasFailure());
    matched += bench.matched();
  });
  if (std::getenv("SELFPROJ_SEED") == nullptr) {
    EXPECT_GT(matched, 20'000U) << "too little was compared";
  }
}

// As HlsColumnMoments.LargestImage and TakesABeatEveryStep.
TEST(HlsColumnRuns, LargestImage) {
  Random random(1);
  MomentsBench bench(runs_kernel());
  MomentsFrame frame = random_moments_frame(random, spec::kMaxColumns, spec::kMaxRows, Mode::grey, true);
  frame.threshold = 0;
  frame.window = {};
  std::fill(frame.pixels.begin(), frame.pixels.end(), std::uint8_t{255});
  bench.play(frame, 0, random);
  bench.finish();
  EXPECT_EQ(bench.matched(), spec::kMaxColumns / 2U);
}
TEST(HlsColumnRuns, TakesABeatEveryStep) {
  Random random(1);
  for (const Mode mode : kModes) {
    for (const int columns : {4, 8, 12, 64, 512}) {
      for (const int rows : {2, 3, 16}) {
        SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode));
        MomentsBench bench(runs_kernel());
        for (int frame = 0; frame < 4; ++frame) {
          bench.play(random_moments_frame(random, columns, rows, mode, true), 0, random);
          ASSERT_TRUE(bench.all_read());
        }
        bench.finish();
      }
    }
  }
}

// All small sizes, one frame right behind the other.
TEST(HlsColumnMoments, SmallSizes) {
  Random random(1);
  for (const Mode mode : kModes) {
    for (int columns = 4; columns <= 32; columns += 4) {
      for (int rows = 1; rows <= 7; ++rows) {
        SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode));
        MomentsBench bench(moments_kernel());
        for (int frame = 0; frame < 5; ++frame) {
          bench.play(random_moments_frame(random, columns, rows, mode), 0, random);
        }
        bench.finish();
        ASSERT_FALSE(HasFailure());
      }
    }
  }
}

// Every sum at its largest value.
TEST(HlsColumnMoments, LargestImage) {
  Random random(1);
  for (const Mode mode : kModes) {
    MomentsBench bench(moments_kernel());
    MomentsFrame frame = random_moments_frame(random, spec::kMaxColumns, spec::kMaxRows, mode);
    frame.threshold = 0;
    std::fill(frame.pixels.begin(), frame.pixels.end(), std::uint8_t{255});
    bench.play(frame, 0, random);
    bench.finish();
    EXPECT_EQ(bench.matched(), (mode == Mode::binary ? 1U : 2U) * spec::kMaxColumns / 4);
  }
}

// A beat in every step, without a wait between frames of one size and two rows or more. In steps, this is the promise
// of the RTL.
TEST(HlsColumnMoments, TakesABeatEveryStep) {
  Random random(1);
  for (const Mode mode : kModes) {
    for (const int columns : {4, 8, 12, 64, 512, 2048}) {
      for (const int rows : {2, 3, 16}) {
        SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode));
        MomentsBench bench(moments_kernel());
        for (int frame = 0; frame < 4; ++frame) {
          bench.play(random_moments_frame(random, columns, rows, mode), 0, random);
          ASSERT_TRUE(bench.all_read());
        }
        EXPECT_EQ(bench.steps(), static_cast<std::uint64_t>(4 * rows * columns / 4));
        bench.finish();
      }
    }
  }
}

TEST(HlsGrayDecoder, RandomSequences) {
  std::uint64_t pixels = 0;
  for_cases(60, [&](Random& random) {
    GrayKernelBench bench(random.chance(70) ? gray_kernel() : gray_top());
    play_gray_sequences(bench, 6, 100, random);
    ASSERT_FALSE(HasFailure());
    pixels += bench.pixels();
  });
  if (std::getenv("SELFPROJ_SEED") == nullptr) {
    EXPECT_GT(pixels, 400'000U) << "too little was compared";
  }
}

// A beat in every step, codes of every pair, frames of three lines and more. In steps, this is the promise of the RTL.
TEST(HlsGrayDecoder, TakesABeatEveryStep) {
  Random random(1);
  for (const int bits : {1, 2, 7, 12}) {
    for (const int columns : {4, 8, 64}) {
      for (const bool median : {false, true}) {
        const GraySettings settings{.rows = 4, .columns = columns, .bits = bits};
        GrayKernelBench bench(gray_kernel());
        for (int frame = 0; frame < 6 * bits; ++frame) {
          bench.play(settings, median,
                     {.pixels = random.bytes(static_cast<std::size_t>(4 * columns)), .pattern = frame % (2 * bits)}, 0,
                     random);
        }
        EXPECT_EQ(bench.steps(), static_cast<std::uint64_t>(6 * bits * columns));
        bench.finish(columns);
        const auto pairs = static_cast<std::uint64_t>(2 * bits + 1);
        EXPECT_EQ(bench.pixels(), pairs * 4 * static_cast<std::uint64_t>(columns));
        ASSERT_FALSE(HasFailure());
      }
    }
  }
}

}  // namespace
}  // namespace selfproj::test
