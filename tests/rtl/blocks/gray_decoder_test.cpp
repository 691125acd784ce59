// Compares the Gray-code decoder with its model: with its own memory, and with a memory played by the bench, whose
// words may come too late.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>

#include "Vsp_gray_core_ports.h"
#include "Vsp_gray_core_small_ports.h"
#include "Vsp_gray_decoder_ports.h"
#include "tests/rtl/blocks/gray_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(GrayCore, RandomSequencesEqualTheModel) {
  std::uint64_t pixels = 0;
  for_cases(150, [&](Random& random) {
    GrayBench<Vsp_gray_core> bench(random);
    play_gray_frames(bench, {.frames = 250}, random);
    ASSERT_FALSE(HasFatalFailure());
    pixels += bench.pixels();
  });
  if (runs_all_cases()) {
    EXPECT_GT(pixels, 200'000U) << "too little was compared";
  }
}

// A build for fewer bits and a small image that uses all of the memory.
TEST(GrayCoreSmall, RandomSequencesEqualTheModel) {
  std::uint64_t pixels = 0;
  for_cases(60, [&](Random& random) {
    GrayBench<Vsp_gray_core_small> bench(random);
    play_gray_frames(bench, {.max_columns = 12, .max_rows = 3, .max_bits = 3, .frames = 250}, random);
    ASSERT_FALSE(HasFatalFailure());
    pixels += bench.pixels();
  });
  if (runs_all_cases()) {
    EXPECT_GT(pixels, 20'000U) << "too little was compared";
  }
}

// Plays several cycles of every m without a gap. A code image comes after every pair from the m-th on. The image has
// more words than the near memories of sp_gray_memory.
template <typename Dut>
void every_number_of_bits() {
  constexpr int kRows = 3;
  constexpr int kBeats = 16;  // of a line
  Random random(1);
  GrayBench<Dut> bench(random);
  for (int bits = 1; bits <= model::GrayDecoder::kMaxBits; ++bits) {
    bench.settings = {.rows = kRows, .columns = 4 * kBeats, .bits = bits, .threshold = 5};
    const std::uint64_t before = bench.pixels();
    constexpr int kCycles = 3;
    for (int frame = 0; frame < kCycles * 2 * bits; ++frame) {
      for (int i = 0; i < kRows * kBeats; ++i) {
        GrayBeat beat{.start = i == 0,
                      .line_start = i % kBeats == 0,
                      .line_end = i % kBeats == kBeats - 1,
                      .last_row = i >= (kRows - 1) * kBeats};
        for (std::uint8_t& pixel : beat.pixels) {
          pixel = static_cast<std::uint8_t>(random.between(0, 30));
        }
        bench.clock(beat, frame % (2 * bits), 0);
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
    }
    bench.idle(8);
    const auto pairs = static_cast<std::uint64_t>((kCycles - 1) * bits + 1);
    ASSERT_EQ(bench.pixels() - before, kRows * kBeats * 4 * pairs) << "m = " << bits;
  }
}

TEST(GrayCore, EveryNumberOfBits) { every_number_of_bits<Vsp_gray_core>(); }
TEST(GrayDecoder, EveryNumberOfBits) { every_number_of_bits<Vsp_gray_decoder>(); }

// ... and frames for whose codes there is no room
TEST(GrayDecoder, WordsThatComeTooLate) {
  std::uint64_t pixels = 0;
  std::uint64_t late = 0;
  for_cases(110, [&](Random& random) {
    GrayBench<Vsp_gray_decoder> bench(random);
    bench.late_permille = random.chance(20) ? 0 : random.between(0, 10);
    bench.busy_percent = random.chance(50) ? 0 : random.between(0, 10);
    play_gray_frames(bench, {.max_bits = 6, .frames = 250}, random);
    ASSERT_FALSE(HasFatalFailure());
    pixels += bench.pixels();
    late += bench.late();
  });
  if (runs_all_cases()) {
    EXPECT_GT(pixels, 100'000U) << "too little was compared";
    EXPECT_GT(late, 500U) << "too little came too late";
  }
}

}  // namespace
}  // namespace selfproj::test
