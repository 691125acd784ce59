// Soak: random small frames of 12 and 10 bits, and of 8 and 16 pixels a clock, and some of up to 4,096 columns, with
// stalls and faults, every packet compared with the model, every loss counted.
//
//     wide_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
#include <cstdint>

#include "Vboard_eight.h"
#include "Vboard_eight_of_twelve.h"
#include "Vboard_sixteen.h"
#include "Vboard_ten.h"
#include "Vboard_twelve.h"
#include "Vboard_widest.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(WideSoak, EveryPacketEqualsTheModelOrIsCountedAsLost) {
  FrameCounts counts;
  soak(counts.frames, 1'000'000, [&](std::uint64_t seed) {
    const int faults = seed % 10 < 5 ? 0 : 20;
    if (seed % 25 == 0) {
      return play_random_frames<Vboard_widest>(
          seed, {.max_columns = 4096, .max_rows = 15, .runs = true, .compact = true, .fault_percent = faults}, counts);
    }
    switch (seed % 5) {
      case 0:
        return play_random_frames<Vboard_twelve>(
            seed, {.pixel_bits = 12, .runs = true, .compact = true, .fault_percent = faults}, counts);
      case 1:
        return play_random_frames<Vboard_ten>(
            seed, {.pixel_bits = 10, .image = false, .runs = true, .region = false, .fault_percent = faults}, counts);
      case 2:
        return play_random_frames<Vboard_eight>(
            seed, {.lanes = 8, .runs = true, .compact = true, .fault_percent = faults}, counts);
      case 3:
        return play_random_frames<Vboard_eight_of_twelve>(
            seed, {.pixel_bits = 12, .lanes = 8, .runs = true, .fault_percent = faults}, counts);
      default:
        return play_random_frames<Vboard_sixteen>(
            seed, {.lanes = 16, .runs = true, .region = false, .compact = true, .fault_percent = faults}, counts);
    }
  });
  report_soak("wide_soak",
              "The boards' RTL for pixels of 12 and 10 bits, and for 8 and 16 pixels a clock, against the model, "
              "stalls and faults",
              figures_of(counts));
}

}  // namespace
}  // namespace selfproj::test
