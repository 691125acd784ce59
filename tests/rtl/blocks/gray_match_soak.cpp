// Soak of the matching block: random look-ups, every one compared with the model.
//
//     gray_match_soak [LOOKUPS] [FIRST_SEED]      10,000,000 look-ups from seed 1 on by default
#include <cstdint>

#include "Vsp_gray_match_ports.h"
#include "tests/rtl/blocks/gray_match_bench.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryLookUpEqualsTheModel) {
  constexpr GrayMatchBuild kBuild{1024, 4, 2};
  std::uint64_t pixels = 0;
  std::uint64_t lates = 0;
  soak(pixels, 10'000'000, [&](std::uint64_t seed) {
    Random random(seed);
    GrayMatchBench<Vsp_gray_match> bench(random, kBuild);
    bench.late_permille = random.chance(80) ? 0 : 1;
    play_match_frames(bench, kBuild, 200, random);
    pixels += bench.pixels();
    lates += bench.lates();
  });
  report_soak("gray_match_soak", "The matching block's RTL against the model, random look-ups",
              {{"lookups", pixels}, {"mismatches", 0}, {"frames_abandoned", lates}});
}

}  // namespace
}  // namespace selfproj::test
