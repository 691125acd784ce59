// A serial sensor through its front end and the board; lvds_soak runs more of it.
#include <cstdint>

#include "tests/rtl/board/lvds_frames.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(LvdsBoard, PacketsOfASensorsFramesAreThoseOfTheModel) {
  LvdsCounts counts;
  for_cases(3, [&](Random& random, std::uint64_t seed) {
    const int rows = seed == 1 ? 96 : random.between(5, 127);
    play_lvds_frames(seed, 2, rows, 14 * rows, counts.frames, counts);
  });
}
TEST(LvdsBoard, TwentyRowsAt50000FramesASecond) {
  LvdsCounts counts;
  play_lvds_frames(1, 6, 20, 264, counts.few, counts);
}

}  // namespace
}  // namespace selfproj::test
