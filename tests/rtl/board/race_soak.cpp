// Soak: register writes that race frame starts, on boards of 4 lanes of 8 bits and of 8 lanes of 12, every packet
// compared with the model, every loss with the counters.
//
//     race_soak [RACING_FRAMES] [FIRST_SEED]      1,000,000 racing frames from seed 1 on by default
#include <cstdint>

#include "Vboard_codes.h"
#include "Vboard_eight_of_twelve.h"
#include "tests/rtl/board/racing_board.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryFrameTakesTheSettingsInForceWhenItStarts) {
  RaceCounts counts;
  soak(counts.racing, 1'000'000, [&](std::uint64_t seed) {
    if (seed % 2 == 0) {
      play_races<Vboard_codes>(seed, 1000, counts);
    } else {
      play_races<Vboard_eight_of_twelve>(seed, 1000, counts, {.bits = 12, .lanes = 8});
    }
  });
  report_soak("race_soak", "Register writes that race frame starts, two boards, every packet byte and every counter",
              {{"frames", counts.frames},
               {"racing", counts.racing},
               {"writes", counts.writes},
               {"refused", counts.refused},
               {"broken", counts.broken},
               {"packets", counts.delivered},
               {"lost_counted", counts.lost},
               {"mismatches", 0}});
}

}  // namespace
}  // namespace selfproj::test
