// Soak: random frames through the whole board with verdicts, settings, limits and banks written between them, stalls
// and faults: every packet, every register and every loss compared with the models.
//
//     verdict_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
#include <cstdint>

#include "tests/rtl/board/verdict_board.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryVerdictEqualsTheModel) {
  VerdictCounts counts;
  soak(counts.frames, 1'000'000, [&](std::uint64_t seed) { play_verdicts(seed, seed % 2 == 0 ? 0 : 30, 40, counts); });
  report_soak(
      "verdict_soak",
      "The board's RTL with verdicts against the models, random frames with stalls and faults, every packet byte",
      {{"frames", counts.frames},
       {"packets", counts.delivered},
       {"lost_counted", counts.lost},
       {"parts", counts.parts},
       {"bad_parts", counts.bad},
       {"writes_refused", counts.refused},
       {"mismatches", 0}});
}

}  // namespace
}  // namespace selfproj::test
