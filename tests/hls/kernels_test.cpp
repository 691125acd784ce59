// Tests the HLS kernels against the model. Built once with SystemC's integers, once with memories that show writes
// late, and once with the vendor's integers if they are available.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "hls/compact_columns.h"
#include "selfproj/model/packet_payload.h"
#include "tests/hls/gray_kernel_bench.h"
#include "tests/hls/moments_bench.h"

namespace selfproj::test {
namespace {

template <typename Kernel>
MomentsBench::Step kernel_of() {
  return [kernel = std::make_shared<Kernel>()](auto& video, const auto& setup, auto& payload) {
    kernel->step(video, setup, payload);
  };
}
constexpr auto kMomentsKernel = kernel_of<hls::ColumnMomentsKernel>;
constexpr auto kRunsKernel = kernel_of<hls::ColumnRunsKernel>;

MomentsBench::Step moments_top() {
  return [](auto& video, const auto& setup, auto& payload) {
    column_moments_top(video, setup.columns, setup.rows, setup.mode, setup.threshold, setup.first_row, setup.last_row,
                       payload);
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

// One of two kernels in turns, of which the second is that of the top function and keeps its state from case to case.
void random_frames(MomentsBench::Step (*kernel)(), MomentsBench::Step (*top)(), bool runs) {
  std::uint64_t matched = 0;
  for_cases(200, [&](Random& random) {
    MomentsBench bench(random.chance(50) ? kernel() : top());
    play_moments_frames(bench, 40, random, runs);
    matched += bench.matched();
  });
  if (runs_all_cases()) {
    EXPECT_GT(matched, 20'000U) << "too little was compared";
  }
}
TEST(HlsColumnMoments, RandomFrames) { random_frames(kMomentsKernel, moments_top, false); }
TEST(HlsColumnRuns, RandomFrames) { random_frames(kRunsKernel, runs_top, true); }

// As HlsColumnMoments.LargestImage
TEST(HlsColumnRuns, LargestImage) {
  Random random(1);
  MomentsBench bench(kRunsKernel());
  MomentsFrame frame = random_moments_frame(random, spec::kMaxColumns, spec::kMaxRows, model::Mode::grey, true);
  frame.threshold = 0;
  frame.window = {};
  std::fill(frame.pixels.begin(), frame.pixels.end(), std::uint8_t{255});
  bench.play(frame, 0, random);
  bench.finish();
  EXPECT_EQ(bench.matched(), spec::kMaxColumns / 2U);
}
// All small sizes, one frame right behind the other.
TEST(HlsColumnMoments, SmallSizes) {
  Random random(1);
  for (const model::Mode mode : kModes) {
    for (int columns = 4; columns <= 32; columns += 4) {
      for (int rows = 1; rows <= 7; ++rows) {
        SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode));
        MomentsBench bench(kMomentsKernel());
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
  for (const model::Mode mode : kModes) {
    MomentsBench bench(kMomentsKernel());
    MomentsFrame frame = random_moments_frame(random, spec::kMaxColumns, spec::kMaxRows, mode);
    frame.threshold = 0;
    std::fill(frame.pixels.begin(), frame.pixels.end(), std::uint8_t{255});
    bench.play(frame, 0, random);
    bench.finish();
    EXPECT_EQ(bench.matched(), (mode == model::Mode::binary ? 1U : 2U) * spec::kMaxColumns / 4);
  }
}

// A beat in every step, without a wait between frames of one size and two rows or more. In steps, this is the promise
// of the RTL.
void beat_every_step(MomentsBench::Step (*kernel)(), bool runs) {
  Random random(1);
  for (const model::Mode mode : kModes) {
    for (const int columns : {4, 8, 12, 64, 512, 2048}) {
      for (const int rows : {2, 3, 16}) {
        SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode));
        MomentsBench bench(kernel());
        for (int frame = 0; frame < 4; ++frame) {
          bench.play(random_moments_frame(random, columns, rows, mode, runs), 0, random);
          ASSERT_TRUE(bench.all_read());
        }
        EXPECT_EQ(bench.steps(), static_cast<std::uint64_t>(4 * rows * columns / 4));
        bench.finish();
      }
    }
  }
}
TEST(HlsColumnMoments, TakesABeatEveryStep) { beat_every_step(kMomentsKernel, false); }
TEST(HlsColumnRuns, TakesABeatEveryStep) { beat_every_step(kRunsKernel, true); }

// Compact payload of random frames, of all lit pixels and of the strongest runs, with gaps and frames that break.
TEST(HlsCompactColumns, RandomFrames) {
  std::uint64_t beats = 0;
  hls::CompactColumnsKernel kernel;
  for_cases(200, [&](Random& random) {
    const model::Mode mode = random.chance(50) ? model::Mode::grey : model::Mode::grey_over;
    const int columns = 4 * random.between(1, 40);
    const MomentsFrame frame = random_moments_frame(random, columns, random.between(1, 200), mode, random.chance(50));
    model::Runs runs;
    runs.resize(frame.select, columns);
    model::measure_columns(
        {frame.pixels.data(), frame.rows, columns, columns},
        {.mode = mode, .threshold = frame.threshold, .select = frame.select, .gap = frame.gap, .window = frame.window},
        runs.view());
    const std::vector<std::uint8_t> exact = payload_of_moments(frame);
    std::vector<std::uint8_t> compact(model::compact_payload_bytes(columns));
    model::pack_compact(frame.select, columns, runs.view(), compact.data());
    const bool top = random.chance(50);
    const bool broken = random.chance(20);
    const bool strongest = frame.select == model::Select::strongest;
    hls::Stream<hls::AxisBeat<128>> in;
    hls::Stream<hls::AxisBeat<128>> out;
    std::vector<std::uint8_t> found;
    for (std::size_t at = 0; at < exact.size(); at += 16) {
      hls::AxisData<128> data = model::load_little_endian<std::uint64_t>(exact.data() + at + 8);
      data = data << 64;
      data = data | hls::AxisData<128>(model::load_little_endian<std::uint64_t>(exact.data() + at));
      in.write(hls::axis_beat<128>(data, at == 0, at + 16 == exact.size() && !broken));
      for (int steps = random.between(1, 3); steps > 0; --steps) {
        top ? compact_columns_top(in, strongest ? 1 : 0, out) : kernel.step(in, strongest, out);
      }
      hls::AxisBeat<128> beat;
      while (out.read_nb(beat)) {
        EXPECT_EQ(beat.user != 0, found.empty());
        sim::append_beat(beat, found);
        EXPECT_EQ(beat.last != 0, found.size() == compact.size() && !broken);
        ++beats;
      }
    }
    ASSERT_EQ(found, compact);
  });
  if (runs_all_cases()) {
    EXPECT_GT(beats, 2'000U) << "too little was compared";
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
  if (runs_all_cases()) {
    EXPECT_GT(pixels, 400'000U) << "too little was compared";
  }
}

// A beat in every step, codes of every pair, frames of three lines and more. In steps, this is the promise of the RTL.
TEST(HlsGrayDecoder, TakesABeatEveryStep) {
  Random random(1);
  for (const int bits : {1, 2, 7, 12}) {
    for (const int columns : {4, 8, 64}) {
      for (const bool median : {false, true}) {
        const model::GraySettings settings{.rows = 4, .columns = columns, .bits = bits};
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
