// Soak: random frames through whole boards with verdicts, of 8 and 12 bits with 4 and 8 lanes, of 8 and 10 bits with
// 16, settings,
// limits and banks written between them, stalls and faults: every packet, every register and every loss compared with
// the models.
//
//     verdict_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
#include <cstdint>

#include "Vboard_eight.h"
#include "Vboard_sixteen.h"
#include "Vboard_twelve.h"
#include "Vboard_verdict.h"
#include "Vboard_verdict_eight_of_twelve.h"
#include "Vboard_verdict_sixteen_of_ten.h"
#include "tests/rtl/board/verdict_board.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryVerdictEqualsTheModel) {
  VerdictCounts counts;
  soak(counts.frames, 1'000'000, [&](std::uint64_t seed) {
    const int faults = seed % 2 == 0 ? 0 : 30;
    switch (seed / 2 % 6) {
      case 0:
        return play_verdicts<Vboard_twelve>(seed, faults, 40, counts);
      case 1:
        return play_verdicts<Vboard_eight>(seed, faults, 40, counts);
      case 2:
        return play_verdicts<Vboard_sixteen>(seed, faults, 40, counts);
      case 3:
        return play_verdicts<Vboard_verdict_eight_of_twelve>(seed, faults, 40, counts);
      case 4:
        return play_verdicts<Vboard_verdict_sixteen_of_ten>(seed, faults, 40, counts);
      default:
        return play_verdicts<Vboard_verdict>(seed, faults, 40, counts);
    }
  });
  report_soak(
      "verdict_soak",
      "Six boards with verdicts, of 8 to 12 bits and 4 to 16 pixels a clock, against the models, random frames with "
      "stalls and faults, every packet byte",
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
