// Soak: register writes that race frame starts, every packet compared with the model, every loss with the counters.
//
//     race_soak [RACING_FRAMES] [FIRST_SEED]      1,000,000 racing frames from seed 1 on by default
//
// Ends with a line that says what was compared; exit status 1 at the first mismatch or uncounted loss.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "Vboard_codes.h"
#include "host/files/results_file.h"
#include "tests/rtl/board/racing_board.h"

namespace {

std::uint64_t g_frames = 1'000'000;
std::uint64_t g_seed = 1;

}  // namespace

namespace selfproj::test {
namespace {

TEST(Soak, EveryFrameTakesTheSettingsInForceWhenItStarts) {
  RaceCounts counts;
  std::uint64_t next_report = 100'000;
  for (std::uint64_t seed = g_seed; counts.racing < g_frames; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: race_soak 1 " << seed);
    play_races<Vboard_codes>(seed, 1000, counts);
    ASSERT_FALSE(HasFailure());
    if (counts.racing >= next_report) {
      std::printf("%llu racing frames\n", static_cast<unsigned long long>(counts.racing));
      std::fflush(stdout);
      next_report += 100'000;
    }
  }
  std::printf(
      "%llu frames, %llu of them beside one of %llu register writes (%llu refused); matched %llu packets, "
      "0 mismatches; %llu packets lost in full FIFOs or too close to each other, all of them counted\n",
      static_cast<unsigned long long>(counts.frames), static_cast<unsigned long long>(counts.racing),
      static_cast<unsigned long long>(counts.writes), static_cast<unsigned long long>(counts.refused),
      static_cast<unsigned long long>(counts.delivered), static_cast<unsigned long long>(counts.lost));
  write_results("race_soak", "Register writes that race frame starts, every packet byte and every counter",
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

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    g_frames = std::strtoull(argv[1], nullptr, 10);
  }
  if (argc > 2) {
    g_seed = std::strtoull(argv[2], nullptr, 10);
  }
  return RUN_ALL_TESTS();
}
