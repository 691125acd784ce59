// Soak: very many random small frames with stalls on both sides, every packet compared with the model.
//
//     board_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
//
// The last line says what was compared. The first mismatch or uncounted loss ends the program with exit status 1.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "Vboard.h"
#include "host/files/results_file.h"
#include "tests/rtl/board/random_frames.h"

namespace {

std::uint64_t g_frames = 1'000'000;
std::uint64_t g_seed = 1;

}  // namespace

namespace selfproj::test {
namespace {

TEST(Soak, EveryPacketEqualsTheModelOrIsCountedAsLost) {
  FrameCounts counts;
  std::uint64_t next_report = 100'000;
  for (std::uint64_t seed = g_seed; counts.frames < g_frames; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: board_soak 1 " << seed);
    play_random_frames<Vboard>(seed, {.fault_percent = seed % 2 == 0 ? 0 : 20}, counts);
    ASSERT_FALSE(HasFailure());
    if (counts.frames >= next_report) {
      std::printf("%llu frames\n", static_cast<unsigned long long>(counts.frames));
      std::fflush(stdout);
      next_report += 100'000;
    }
  }
  std::printf(
      "matched %llu packets of %llu frames (%llu image lines beside them), %llu bytes, 0 mismatches; %llu frames "
      "lost in full FIFOs or too close to each other, all of them counted\n",
      static_cast<unsigned long long>(counts.delivered), static_cast<unsigned long long>(counts.frames),
      static_cast<unsigned long long>(counts.image_delivered), static_cast<unsigned long long>(counts.bytes),
      static_cast<unsigned long long>(counts.lost));
  write_results("board_soak",
                "The board's RTL against the model, random frames with stalls and faults, every packet byte",
                {{"frames", counts.frames},
                 {"packets", counts.delivered},
                 {"image_lines", counts.image_delivered},
                 {"bytes", counts.bytes},
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
