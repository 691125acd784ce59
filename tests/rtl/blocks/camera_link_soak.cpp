// Soak: frames of 96 x 512 pixels at 10,000 frames a second, from the bits of a Camera Link camera's lanes, with skew
// and jitter, to the packets of the board, which must be those of the model. Three seeds in four are Full, one of them
// with all links in one bank, the fourth is 80 bit; in every third seed cables are pulled in one frame of 20.
//
//     camera_link_soak [FRAMES] [FIRST_SEED]      100,000 frames from seed 1 on by default
#include <cstdint>

#include "Vecp5_camera_link_bank_ports.h"
#include "Vecp5_camera_link_eighty_ports.h"
#include "Vecp5_camera_link_full_ports.h"
#include "tests/rtl/blocks/camera_link_to_board.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryFrameOfACameraLinkCameraEqualsTheModel) {
  CameraRun full;
  CameraRun eighty;
  std::uint64_t frames = 0;
  soak(frames, 100'000, [&](std::uint64_t seed) {
    const int pulled = seed % 3 == 0 ? static_cast<int>(1 + seed % 17) : -1;
    const unsigned links = pulled < 0 ? 0 : static_cast<unsigned>(1 + seed % 7);
    CameraRun run;
    if (seed % 4 == 0) {
      play_camera<Vecp5_camera_link_eighty>(seed, 10, 20, run, 14, pulled, links);
    } else if (seed % 4 == 2) {
      play_camera<Vecp5_camera_link_bank>(seed, 8, 20, run, 4, pulled, links);
    } else {
      play_camera<Vecp5_camera_link_full>(seed, 8, 20, run, 4, pulled, links);
    }
    if (pulled < 0) {
      EXPECT_GE(run.frames_per_second(), kFramesPerSecond);
    }
    CameraRun& all = seed % 4 == 0 ? eighty : full;
    all.frames += run.frames;
    all.broken += run.broken;
    all.interrupted += run.interrupted;
    frames += run.frames;
  });
  report_soak("camera_link_soak",
              "Camera Link Full and 80 bit, bits of the lanes to packets of the board, 96 x 512 at 10,000 a second",
              {{"frames_full", full.frames},
               {"frames_eighty_bits", eighty.frames},
               {"interrupted", full.interrupted + eighty.interrupted},
               {"broken_counted", full.broken + eighty.broken},
               {"mismatches", 0},
               {"lost", 0}});
}

}  // namespace
}  // namespace selfproj::test
