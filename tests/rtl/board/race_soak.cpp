// Soak: register writes that race frame starts, every packet compared with the model, every loss with the counters.
//
//     race_soak [RACING_FRAMES] [FIRST_SEED]      1,000,000 racing frames from seed 1 on by default
#include <cstdint>

#include "Vboard_codes.h"
#include "tests/rtl/board/racing_board.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryFrameTakesTheSettingsInForceWhenItStarts) {
  RaceCounts counts;
  soak(counts.racing, 1'000'000, [&](std::uint64_t seed) { play_races<Vboard_codes>(seed, 1000, counts); });
  report_soak("race_soak", "Register writes that race frame starts, every packet byte and every counter",
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
