// Soak of the Gray-code decoder: random sequences, every code compared with the model.
//
//     gray_soak [PIXELS] [FIRST_SEED]      10,000,000 pixels from seed 1 on by default
//
// A third of the sequences runs with on-chip memory, a third with a memory whose words come too late at random, and a
// third with an external memory of random latency and stalls.
#include <cstdint>

#include "Vsp_gray_core_ports.h"
#include "Vsp_gray_decoder_ports.h"
#include "tests/rtl/blocks/gray_axi_bench.h"
#include "tests/rtl/blocks/gray_bench.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryCodeEqualsTheModel) {
  constexpr std::uint64_t kPixels = 10'000'000;
  const std::uint64_t third = soak_command.number(0, kPixels) / 3;
  std::uint64_t on_chip = 0;
  std::uint64_t flagged = 0;
  std::uint64_t late = 0;
  GrayAxiCounts external;
  std::uint64_t all = 0;
  soak(all, kPixels, [&](std::uint64_t seed) {
    if (on_chip <= third) {
      Random random(seed);
      GrayBench<Vsp_gray_core> bench(random);
      play_gray_frames(bench, {.max_columns = 64, .max_rows = 16, .frames = 250}, random);
      on_chip += bench.pixels();
    }
    if (flagged <= third) {
      Random random(seed);
      GrayBench<Vsp_gray_decoder> bench(random);
      bench.late_permille = random.between(0, 3);
      bench.busy_percent = random.between(0, 5);
      play_gray_frames(bench, {.max_columns = 64, .max_rows = 16, .frames = 250}, random);
      flagged += bench.pixels();
      late += bench.late();
    }
    if (external.pixels <= third) {
      play_gray_axi_frames(seed, external);
    }
    all = on_chip + flagged + external.pixels;
  });
  report_soak(
      "gray_soak", "The Gray decoder's RTL against the model, random sequences, every code",
      {{"pixels", all},
       {"mismatches", 0},
       {"on_chip", {{"pixels", on_chip}}},
       {"late_words", {{"pixels", flagged}, {"words", late}}},
       {"external", {{"pixels", external.pixels}, {"frames", external.frames}, {"abandoned", external.lates}}}});
}

}  // namespace
}  // namespace selfproj::test
