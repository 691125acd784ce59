// Camera Link Full and 80 bit from the bits of the lanes to the packets of the board: a few frames of 96 x 512 pixels
// at 10,000 frames a second. camera_link_soak plays more.
#include <gtest/gtest.h>

#include "Vecp5_camera_link_bank_ports.h"
#include "Vecp5_camera_link_eighty_ports.h"
#include "Vecp5_camera_link_full_ports.h"
#include "tests/rtl/blocks/camera_link_to_board.h"

namespace selfproj::test {
namespace {

TEST(CameraLinkBoard, FullAt10000FramesASecond) {
  CameraRun run;
  play_camera<Vecp5_camera_link_full>(1, 8, 2, run, 4);
  EXPECT_GE(run.frames_per_second(), kFramesPerSecond);
}

TEST(CameraLinkBoard, FullWithACablePulled) {
  CameraRun run;
  play_camera<Vecp5_camera_link_full>(2, 8, 3, run, 4, 1, 0b100);
  EXPECT_EQ(run.broken, 1U);
}

TEST(CameraLinkBoard, FullInOneBankWithACablePulled) {
  CameraRun run;
  play_camera<Vecp5_camera_link_bank>(4, 8, 3, run, 4, 1, 0b010);
  EXPECT_EQ(run.broken, 1U);
}

TEST(CameraLinkBoard, EightyBitsWithAllCablesPulled) {
  CameraRun run;
  play_camera<Vecp5_camera_link_eighty>(3, 10, 3, run, 14, 1, 0b111);
  EXPECT_EQ(run.broken, 1U);
}

}  // namespace
}  // namespace selfproj::test
