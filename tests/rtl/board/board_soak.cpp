// Soak: very many random small frames with stalls on both sides, every packet compared with the model, every loss
// counted.
//
//     board_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
#include <cstdint>

#include "Vboard.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryPacketEqualsTheModelOrIsCountedAsLost) {
  FrameCounts counts;
  soak(counts.frames, 1'000'000, [&](std::uint64_t seed) {
    play_random_frames<Vboard>(seed, {.fault_percent = seed % 2 == 0 ? 0 : 20}, counts);
  });
  report_soak("board_soak",
              "The board's RTL against the model, random frames with stalls and faults, every packet byte",
              figures_of(counts));
}

}  // namespace
}  // namespace selfproj::test
