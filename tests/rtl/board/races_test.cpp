// Register writes that race frame starts, on a board with all options built in (Vboard_codes). race_soak runs more
// of the same.
#include <gtest/gtest.h>

#include <cstdint>

#include "Vboard_codes.h"
#include "tests/rtl/board/racing_board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(Races, EveryFrameTakesTheSettingsInForceWhenItStarts) {
  RaceCounts counts;
  for_cases(40, [&](std::uint64_t seed) { play_races<Vboard_codes>(seed, 250, counts); });
  if (!runs_all_cases()) {
    return;
  }
  EXPECT_GT(counts.racing, 3000U);
  EXPECT_GT(counts.refused, 300U);
  EXPECT_GT(counts.frames - counts.broken, counts.frames / 2);
  // For each of these registers and each of the clocks 0 to 9 after a write reached it, more than five frames started
  // in that clock.
  for (const std::uint32_t address : {spec::kRegControl, spec::kRegSize, spec::kRegMeasure, spec::kRegTimeout,
                                      spec::kRegDecode, spec::kRegTriggerControl, spec::kRegFrames}) {
    for (const std::uint64_t hits : counts.hits.at(address / 4)) {
      EXPECT_GT(hits, 5U) << std::hex << address;
    }
  }
}

}  // namespace
}  // namespace selfproj::test
