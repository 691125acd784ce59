// Soak of the Gray-code decoder: random sequences, every code compared with the model.
//
//     gray_soak [PIXELS] [FIRST_SEED]      10,000,000 pixels from seed 1 on by default
//
// A third of the sequences runs with on-chip memory, a third with a memory whose words come too late at random, and a
// third with an external memory of random latency and stalls. The last line says what was compared. The first mismatch
// ends the program with exit status 1.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "Vsp_gray_core_ports.h"
#include "Vsp_gray_decoder_ports.h"
#include "host/files/results_file.h"
#include "tests/rtl/blocks/gray_axi_bench.h"
#include "tests/rtl/blocks/gray_bench.h"
#include "tests/rtl/blocks/gray_frames_bench.h"

namespace {

std::uint64_t g_pixels = 10'000'000;
std::uint64_t g_seed = 1;

}  // namespace

namespace selfproj::test {
namespace {

TEST(Soak, EveryCodeEqualsTheModel) {
  std::uint64_t on_chip = 0;
  std::uint64_t flagged = 0;
  std::uint64_t late = 0;
  GrayAxiCounts external;
  for (std::uint64_t seed = g_seed; on_chip + flagged + external.pixels < g_pixels; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: gray_soak 1 " << seed);
    if (3 * on_chip <= g_pixels) {
      Random random(seed);
      GrayBench<Vsp_gray_core> bench(random);
      play_gray_frames(bench, {.max_columns = 64, .max_rows = 16, .frames = 250}, random);
      on_chip += bench.pixels();
    }
    ASSERT_FALSE(HasFailure());
    if (3 * flagged <= g_pixels) {
      Random random(seed);
      GrayBench<Vsp_gray_decoder> bench(random);
      bench.late_permille = random.between(0, 3);
      bench.busy_percent = random.between(0, 5);
      play_gray_frames(bench, {.max_columns = 64, .max_rows = 16, .frames = 250}, random);
      flagged += bench.pixels();
      late += bench.late();
    }
    ASSERT_FALSE(HasFailure());
    if (3 * external.pixels <= g_pixels) {
      play_gray_axi_frames(seed, external);
    }
    ASSERT_FALSE(HasFailure());
  }
  std::printf(
      "matched %llu pixels, 0 mismatches: %llu with on-chip memory, %llu where %llu words came too late, %llu with an "
      "external memory, where the decoder abandoned %llu of %llu frames\n",
      static_cast<unsigned long long>(on_chip + flagged + external.pixels), static_cast<unsigned long long>(on_chip),
      static_cast<unsigned long long>(flagged), static_cast<unsigned long long>(late),
      static_cast<unsigned long long>(external.pixels), static_cast<unsigned long long>(external.lates),
      static_cast<unsigned long long>(external.frames));
  write_results(
      "gray_soak", "The Gray decoder's RTL against the model, random sequences, every code",
      {{"pixels", on_chip + flagged + external.pixels},
       {"mismatches", 0},
       {"on_chip", {{"pixels", on_chip}}},
       {"late_words", {{"pixels", flagged}, {"words", late}}},
       {"external", {{"pixels", external.pixels}, {"frames", external.frames}, {"abandoned", external.lates}}}});
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    g_pixels = std::strtoull(argv[1], nullptr, 10);
  }
  if (argc > 2) {
    g_seed = std::strtoull(argv[2], nullptr, 10);
  }
  return RUN_ALL_TESTS();
}
