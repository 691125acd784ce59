// Soak: random small frames of 12 and 10 bits with stalls and faults, every packet compared with the model, every loss
// counted.
//
//     wide_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
#include <cstdint>

#include "Vboard_ten.h"
#include "Vboard_twelve.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(WideSoak, EveryPacketEqualsTheModelOrIsCountedAsLost) {
  FrameCounts counts;
  soak(counts.frames, 1'000'000, [&](std::uint64_t seed) {
    const int faults = seed % 4 < 2 ? 0 : 20;
    if (seed % 2 == 0) {
      play_random_frames<Vboard_twelve>(seed, {.pixel_bits = 12, .fault_percent = faults}, counts);
    } else {
      play_random_frames<Vboard_ten>(seed, {.pixel_bits = 10, .image = false, .region = false, .fault_percent = faults},
                                     counts);
    }
  });
  report_soak("wide_soak", "The boards' RTL for pixels of 12 and 10 bits against the model, stalls and faults",
              figures_of(counts));
}

}  // namespace
}  // namespace selfproj::test
