// Soak: a serial sensor with 16 lanes, bit by bit, through its front end and the board. Every beat must be the one that
// was sent, and every packet that of the model.
//
//     lvds_soak [FRAMES_OF_96_ROWS] [FRAMES_OF_20_ROWS] [FIRST_SEED]      100,000 of each from seed 1 on by default
//
// By the clocks' ratios, 10,743 and 51,948 frames of 512 columns a second
#include <cstdint>

#include "tests/rtl/board/lvds_frames.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, ASerialSensorThroughTheFrontEndAndTheBoard) {
  LvdsCounts counts;
  soak(
      counts.frames, 100'000, [&](std::uint64_t seed) { play_lvds_frames(seed, 50, 96, 1300, counts.frames, counts); },
      0, 2);
  soak(
      counts.few, 100'000, [&](std::uint64_t seed) { play_lvds_frames(seed, 50, 20, 264, counts.few, counts); }, 1, 2);
  report_soak("lvds_soak", "A serial sensor's lanes, bit by bit, through front end and board",
              {{"frames_of_96_rows", counts.frames},
               {"frames_of_20_rows", counts.few},
               {"beats", counts.beats},
               {"packets", counts.packets},
               {"mismatches", 0}});
}

}  // namespace
}  // namespace selfproj::test
