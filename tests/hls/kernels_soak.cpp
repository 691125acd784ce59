// Soak of the HLS kernels: random frames and sequences, every word compared with the model.
//
//     hls_soak [FRAMES [PIXELS [FIRST_SEED]]]      100,000 frames of moments and as many of strongest runs, 10,000,000
//     decoded pixels, from seed 1 on
#include <cstdint>
#include <memory>

#include "tests/hls/gray_kernel_bench.h"
#include "tests/hls/moments_bench.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

#ifdef SELFPROJ_HLS_VENDOR_TYPES
constexpr const char* kName = "hls_soak_ap";
constexpr const char* kAbout = "The HLS kernels with the vendor's integers against the model";
#else
constexpr const char* kName = "hls_soak";
constexpr const char* kAbout = "The HLS kernels with SystemC's integers against the model";
#endif

// Adds the figures of a test; with the last one, reports all.
void add_results(const char* test, nlohmann::ordered_json figures) {
  static nlohmann::ordered_json all;
  figures["mismatches"] = 0;
  all[test] = std::move(figures);
  if (all.size() == 3) {
    report_soak(kName, kAbout, all);
  }
}

template <typename Kernel>
void soak_moments(const char* test, bool runs) {
  constexpr int kFrames = 200;  // a seed
  const auto kernel = std::make_shared<Kernel>();
  std::uint64_t frames = 0;
  std::uint64_t beats = 0;
  soak(
      frames, 100'000,
      [&](std::uint64_t seed) {
        Random random(seed);
        MomentsBench bench([&](auto& video, const auto& setup, auto& payload) { kernel->step(video, setup, payload); });
        play_moments_frames(bench, kFrames, random, runs);
        frames += kFrames;
        beats += bench.matched();
      },
      0, 2);
  add_results(test, {{"frames", frames}, {"beats", beats}});
}

TEST(HlsSoak, EveryMomentEqualsTheModel) { soak_moments<hls::ColumnMomentsKernel>("moments", false); }
TEST(HlsSoak, EveryRunEqualsTheModel) { soak_moments<hls::ColumnRunsKernel>("runs", true); }

TEST(HlsSoak, EveryCodeEqualsTheModel) {
  std::uint64_t pixels = 0;
  soak(
      pixels, 10'000'000,
      [&](std::uint64_t seed) {
        Random random(seed);
        const auto kernel = std::make_shared<hls::GrayDecoderKernel<64, 16>>();
        GrayKernelBench bench([&](auto& video, const auto& setup, auto pattern, auto& codes) {
          kernel->step(video, setup, pattern, codes);
        });
        play_gray_sequences(bench, 10, 100, random);
        pixels += bench.pixels();
      },
      1, 2);
  add_results("codes", {{"pixels", pixels}});
}

}  // namespace
}  // namespace selfproj::test
