// Soak of the HLS kernels: random frames and sequences, every word compared with the model.
//
//     hls_soak [FRAMES [PIXELS [FIRST_SEED]]]      100,000 frames of moments and as many of strongest runs, 10,000,000
//     decoded pixels, from seed 1 on
//
// Ends with three lines that say what was compared; exit status 1 at the first mismatch.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "host/files/results_file.h"
#include "tests/hls/gray_kernel_bench.h"
#include "tests/hls/moments_bench.h"

namespace {

std::uint64_t g_frames = 100'000;
std::uint64_t g_pixels = 10'000'000;
std::uint64_t g_seed = 1;

nlohmann::ordered_json g_results;

}  // namespace

namespace selfproj::test {
namespace {

TEST(HlsSoak, EveryMomentEqualsTheModel) {
  constexpr std::uint64_t kFrames = 200;  // a seed
  const auto kernel = std::make_shared<hls::ColumnMomentsKernel>();
  std::uint64_t frames = 0;
  std::uint64_t beats = 0;
  for (std::uint64_t seed = g_seed; frames < g_frames; ++seed, frames += kFrames) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: 1 0 " << seed);
    Random random(seed);
    MomentsBench bench([&](auto& video, const auto& setup, auto& payload) { kernel->step(video, setup, payload); });
    play_moments_frames(bench, kFrames, random);
    ASSERT_FALSE(HasFailure());
    beats += bench.matched();
  }
  std::printf("matched the payload of %llu frames, %llu beats of 16 bytes, 0 mismatches\n",
              static_cast<unsigned long long>(frames), static_cast<unsigned long long>(beats));
  g_results["moments"] = {{"frames", frames}, {"beats", beats}, {"mismatches", 0}};
}

TEST(HlsSoak, EveryRunEqualsTheModel) {
  constexpr std::uint64_t kFrames = 200;  // a seed
  const auto kernel = std::make_shared<hls::ColumnRunsKernel>();
  std::uint64_t frames = 0;
  std::uint64_t beats = 0;
  for (std::uint64_t seed = g_seed; frames < g_frames; ++seed, frames += kFrames) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: 1 0 " << seed);
    Random random(seed);
    MomentsBench bench([&](auto& video, const auto& setup, auto& payload) { kernel->step(video, setup, payload); });
    play_moments_frames(bench, kFrames, random, random_runs_frame);
    ASSERT_FALSE(HasFailure());
    beats += bench.matched();
  }
  std::printf("matched the strongest runs of %llu frames, %llu beats of 16 bytes, 0 mismatches\n",
              static_cast<unsigned long long>(frames), static_cast<unsigned long long>(beats));
  g_results["runs"] = {{"frames", frames}, {"beats", beats}, {"mismatches", 0}};
}

TEST(HlsSoak, EveryCodeEqualsTheModel) {
  std::uint64_t pixels = 0;
  for (std::uint64_t seed = g_seed; pixels < g_pixels; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: 0 1 " << seed);
    Random random(seed);
    const auto kernel = std::make_shared<hls::GrayDecoderKernel<64, 16>>();
    GrayKernelBench bench(
        [&](auto& video, const auto& setup, auto pattern, auto& codes) { kernel->step(video, setup, pattern, codes); });
    play_gray_sequences(bench, 10, 100, random);
    ASSERT_FALSE(HasFailure());
    pixels += bench.pixels();
  }
  std::printf("matched %llu decoded pixels, 0 mismatches\n", static_cast<unsigned long long>(pixels));
  g_results["codes"] = {{"pixels", pixels}, {"mismatches", 0}};
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    g_frames = std::strtoull(argv[1], nullptr, 10);
  }
  if (argc > 2) {
    g_pixels = std::strtoull(argv[2], nullptr, 10);
  }
  if (argc > 3) {
    g_seed = std::strtoull(argv[3], nullptr, 10);
  }
  const int status = RUN_ALL_TESTS();
  if (status == 0 && g_results.size() == 3) {
#ifdef SELFPROJ_HLS_VENDOR_TYPES
    const char* name = "hls_soak_ap";
    const char* about = "The HLS kernels with the vendor's integers against the model";
#else
    const char* name = "hls_soak";
    const char* about = "The HLS kernels with SystemC's integers against the model";
#endif
    selfproj::write_results(name, about, g_results);
  }
  return status;
}
