// A serial sensor with 16 lanes and 512 columns, bit by bit, through its front end and the board.
#ifndef SELFPROJ_TESTS_RTL_BOARD_LVDS_FRAMES_H
#define SELFPROJ_TESTS_RTL_BOARD_LVDS_FRAMES_H

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

#include "Vboard.h"
#include "Vsp_lvds_sensor_ports.h"
#include "selfproj/model/board.h"
#include "tests/rtl/blocks/lvds_bench.h"
#include "tests/rtl/board/scoreboard.h"

namespace selfproj::test {

struct LvdsCounts {
  std::uint64_t frames = 0;
  std::uint64_t few = 0;  // with 20 rows
  std::uint64_t beats = 0;
  std::uint64_t packets = 0;
};

// Sends frames with words of 48 MHz (16 x 480 Mbit/s) to a board of 151.2 MHz, `gap` words between them. Every beat
// must be the one that was sent, and every packet that of the model.
inline void play_lvds_frames(std::uint64_t seed, int count, int rows, int gap, std::uint64_t& frames,
                             LvdsCounts& counts) {
  constexpr int kWord = 20833;  // ps
  constexpr int kBoard = 6614;
  LvdsBench<Vsp_lvds_sensor> bench(seed, {.taps = 16}, kWord, kBoard);
  for (std::size_t lane = 0; lane < 17; ++lane) {
    bench.skew[lane] = bench.random().between(-1200, 1200);
    bench.jitter[lane] = bench.random().between(0, 240);
  }
  ASSERT_TRUE(bench.wait_aligned(200'000));
  Scoreboard<Vboard> board;
  board.write({.columns = 512,
               .rows = rows,
               .mode = static_cast<model::Mode>(bench.random().between(0, 2)),
               .threshold = bench.random().between(0, 250)});
  for (int frame = 0; frame < count; ++frame) {
    bench.send(rows, 0, 1, gap);
  }
  std::size_t at = 0;
  const auto on_board = [&] {
    if (at == bench.beats().size()) {
      board.device().gap(1);
    } else {
      const Beat& beat = bench.beats()[at++];
      model::VideoBeat video{.start = beat.start, .line_end = beat.end};
      for (std::size_t i = 0; i < spec::kPixelsPerBeat; ++i) {
        video.pixels.at(i) = static_cast<std::uint16_t>(beat.pixels >> (8 * i) & 0xFF);
      }
      board.device().send(video);
    }
    board.device().run(1);
  };
  for (int quiet = 0; quiet < 10'000;) {
    const bool waits = !bench.frames().queue().empty();
    quiet += bench.step(on_board).b && !waits ? 1 : 0;
  }
  board.finish();
  ASSERT_EQ(bench.expect_frames_sent(), 0);
  ASSERT_EQ(bench.overruns() + bench.cuts() + bench.losses(), 0);
  ASSERT_EQ(board.delivered(spec::kKindMoments), static_cast<std::uint64_t>(count));
  ASSERT_EQ(board.lost(spec::kKindMoments), 0U);
  frames += static_cast<std::uint64_t>(count);
  counts.beats += bench.beats().size();
  counts.packets += board.delivered(spec::kKindMoments);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BOARD_LVDS_FRAMES_H
