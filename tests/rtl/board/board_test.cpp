// Compares the whole board with the model, packet by packet and byte by byte.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "Vboard.h"
#include "Vboard_original.h"
#include "host/files/results_file.h"
#include "selfproj/model/pixel_clock.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr std::uint8_t kMoments = spec::kKindMoments;
constexpr std::uint8_t kImage = spec::kKindImage;

// The gap between the starts of two frames, beyond the beats of a moments packet (docs/using-the-circuits.md).
int small_gap(model::Mode mode) { return mode == model::Mode::binary ? 8 : 14; }

// Together with the tests of the small build and of faults below, 10^5 frames.
TEST(Board, RandomSmallFramesEqualTheModel) { play_all_random_frames<Vboard>(80, {}); }
TEST(OriginalBoard, RandomSmallFramesEqualTheModel) {
  play_all_random_frames<Vboard_original>(80, {.grey = false, .image = false, .region = false});
}

// Lines that are missing, repeated, cut or of wrong length; frame starts that are missing or in mid-frame; pauses
// beyond the time-out.
TEST(Board, RandomFaultsEqualTheModel) {
  FrameCounts counts = play_all_random_frames<Vboard>(60, {.max_columns = 40, .max_rows = 12, .fault_percent = 40});
  if (runs_all_cases()) {
    for (const std::uint32_t status :
         {spec::kStatusShortLine, spec::kStatusLongLine, spec::kStatusStartInFrame, spec::kStatusIncomplete}) {
      EXPECT_GT(counts.by_status[status], 100U) << "status " << status;
    }
  }
}
TEST(OriginalBoard, RandomFaultsEqualTheModel) {
  play_all_random_frames<Vboard_original>(
      40, {.max_columns = 40, .max_rows = 12, .grey = false, .image = false, .region = false, .fault_percent = 40});
}

// Plants each fault in the first, a middle and the last row, and in the first, a middle and the last beat. The good
// frame that follows without a gap is delivered with good status and equals the model's.
TEST(Board, TheFrameAfterAFaultIsRight) {
  Random random(7);
  constexpr int kRows = 24;
  constexpr int kColumns = 32;
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey_over}) {
    for (int fault = 0; fault < kFaults; ++fault) {
      for (const int row : {0, kRows / 2, kRows - 1}) {
        for (const int group : {0, kColumns / 8, kColumns / 4 - 1}) {
          SCOPED_TRACE(::testing::Message() << "fault " << fault << " in row " << row << ", beat " << group);
          Scoreboard<Vboard> board;
          board.write({.image = true, .columns = kColumns, .rows = kRows, .mode = mode, .threshold = 30});
          const auto send = [&](Fault what) {
            const TestImage image = random_image(random, kRows, kColumns);
            for (const model::VideoBeat& beat : with_fault(lines_of(image), what, row, group)) {
              board.device().send(beat);
            }
          };
          send(Fault::none);
          board.device().gap(100);
          send(static_cast<Fault>(fault));
          send(Fault::none);
          board.finish();
          // A start within the last row makes two broken frames, of which the second is too close to the first.
          EXPECT_LE(board.lost(kMoments), static_cast<Fault>(fault) == Fault::start_in_frame ? 1U : 0U);
          EXPECT_GE(board.by_status().at(0), 2U);
          EXPECT_EQ(board.last_status(kMoments), 0U);
          EXPECT_EQ(board.last_header(kMoments).sequence, board.model().frames() - 1);
          if (HasFailure()) {
            return;
          }
        }
      }
    }
  }
}

// The limits of the sizes. 2048 x 1023 pixels of 255 need every bit of every sum.
TEST(Board, ExtremeSizesEqualTheModel) {
  Random random(11);
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    for (const auto& [columns, rows] : std::vector<std::pair<int, int>>{{4, 1},
                                                                        {4, 2},
                                                                        {4, 3},
                                                                        {4, 1023},
                                                                        {8, 1},
                                                                        {8, 2},
                                                                        {8, 1023},
                                                                        {12, 5},
                                                                        {16, 4},
                                                                        {2048, 1},
                                                                        {2048, 2},
                                                                        {2044, 3},
                                                                        {2048, 5},
                                                                        {2048, 1023}}) {
      SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode));
      Scoreboard<Vboard> board;
      const bool bright = mode != model::Mode::grey_over;
      board.write({.columns = columns, .rows = rows, .mode = mode, .threshold = bright ? 0 : 97});
      for (int i = 0; i < 2; ++i) {
        const TestImage image = bright ? constant_image(rows, columns, 255) : random_image(random, rows, columns);
        board.device().send(image.view());
        board.device().gap(static_cast<std::uint32_t>(2 * columns + 40));
      }
      board.finish();
      EXPECT_EQ(board.delivered(kMoments), 2U);
      if (HasFailure()) {
        return;
      }
    }
  }
}

// Windows that begin, end, or lie in between at rows with a single bit, up to the last row of the tallest frames.
TEST(Board, WindowsOfTallFrames) {
  constexpr int kColumns = 8;
  constexpr int kRows = spec::kMaxRows;
  Random random(12);
  Scoreboard<Vboard> board;
  std::uint64_t frames = 0;
  for (int row = 1; row <= kRows; row *= 2) {
    for (const model::RowWindow window :
         {model::RowWindow{row, 0}, model::RowWindow{0, row}, model::RowWindow{row, kRows - row}}) {
      board.write({.columns = kColumns,
                   .rows = kRows,
                   .mode = static_cast<model::Mode>(random.between(0, 2)),
                   .threshold = random.between(0, 254),
                   .window = window});
      TestImage image = constant_image(kRows, kColumns, 0);
      image.pixels = random.bytes(image.pixels.size());
      board.device().send(image.view());
      board.device().gap(100);
      board.play();
      ++frames;
    }
  }
  board.finish();
  EXPECT_EQ(board.delivered(kMoments), frames);
}

// The frames of the thesis: 200 of 96 x 512, with stalls on both sides.
TEST(Board, FullFramesWithStallsEqualTheModel) {
  for_cases(1, [&](Random& random, std::uint64_t seed) {
    Scoreboard<Vboard> board({.seed = seed, .bus_stall_percent = 40, .video_gap_percent = 15});
    board.turn_encoder(151);
    for (int frame = 0; frame < 200; ++frame) {
      if (frame % 20 == 0) {
        board.write({.image = frame % 40 == 0,
                     .columns = 512,
                     .rows = 96,
                     .mode = static_cast<model::Mode>(frame / 20 % 3),
                     .threshold = random.between(0, 255)});
      }
      board.device().send(random_image(random, 96, 512).view());
      board.play();
    }
    board.finish();
    EXPECT_EQ(board.delivered(kMoments), 200U);
    EXPECT_EQ(board.lost(kMoments), 0U);
  });
}

// 12,288 clocks a frame: every clock carries a beat, and nothing is lost, even with raw images. Results: the frames a
// second that follow at the pixel clock of the original system.
TEST(Board, TakesFullFramesBackToBack) {
  constexpr int kFrames = 12;
  Random random(3);
  std::uint64_t clocks = 0;
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    Scoreboard<Vboard> board({.bus_stall_percent = 20});
    board.write({.image = true, .columns = 512, .rows = 96, .mode = mode, .threshold = 100});
    const std::uint64_t before = board.device().clock();
    for (int frame = 0; frame < kFrames; ++frame) {
      board.device().send(random_image(random, 96, 512).view());
    }
    board.play();
    clocks = board.device().clock() - before;
    EXPECT_EQ(clocks, kFrames * 12288U);
    board.finish();
    EXPECT_EQ(board.delivered(kMoments), kFrames);
    EXPECT_EQ(board.lost(kMoments), 0U);
    EXPECT_EQ(board.delivered(kImage), kFrames * 96U);
    EXPECT_EQ(board.lost(kImage), 0U);
  }
  if (!HasFailure()) {
    files::write_results(
        "frame_rate", "Frames of 96 x 512 pixels that the board takes one right behind another, none lost",
        {{"pixel_clock_hz", model::kDefaultPixelClockHz},
         {"frame_clocks", clocks / kFrames},
         {"frames_per_s", static_cast<std::uint64_t>(model::kDefaultPixelClockHz) * kFrames / clocks}});
  }
}

// At a distance of a packet's beats plus the stated small gap no frame is lost. One clock closer, some are lost.
TEST(Board, SmallestDistanceOfFramesIsAsStated) {
  Random random(5);
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey}) {
    for (const auto& [columns, rows] :
         std::vector<std::pair<int, int>>{{4, 1}, {8, 2}, {40, 1}, {64, 2}, {512, 1}, {512, 2}, {1024, 1}}) {
      const int beats = columns / 4 * rows;
      const int distance =
          static_cast<int>(packet_beats(model::moments_payload_bytes(mode, columns))) + small_gap(mode);
      for (const int less : {0, 1}) {
        if (distance - less < beats) {
          continue;  // frames cannot be closer than their own beats
        }
        SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode)
                                          << ", frames " << distance - less << " clocks apart");
        Scoreboard<Vboard> board({.video_period_ps = 6614, .bus_period_ps = 6000});
        board.write({.columns = columns, .rows = rows, .mode = mode, .threshold = 100});
        for (int frame = 0; frame < 20; ++frame) {
          board.device().send(random_image(random, rows, columns).view());
          board.device().gap(static_cast<std::uint32_t>(distance - less - beats));
        }
        board.finish();
        if (less == 0) {
          EXPECT_EQ(board.lost(kMoments), 0U);
        } else {
          EXPECT_EQ(board.lost(kMoments), 10U) << "every second frame comes too early";
        }
      }
    }
  }
}

// Lines of 60 columns and more may follow each other without a gap. Narrower lines are lost and counted.
TEST(Board, RawImageLinesNeedNoGap) {
  Random random(6);
  for (const int columns : {60, 64, 128, 256, 512, 1024, 2048}) {
    Scoreboard<Vboard> board({.bus_period_ps = 6000});
    board.write({.image = true, .columns = columns, .rows = 20});
    for (int frame = 0; frame < 3; ++frame) {
      board.device().send(random_image(random, 20, columns).view());
    }
    board.finish();
    EXPECT_EQ(board.delivered(kImage), 60U) << columns;
    EXPECT_EQ(board.lost(kImage), 0U) << columns;
  }
  Scoreboard<Vboard> board({.bus_period_ps = 6000});
  board.write({.image = true, .columns = 56, .rows = 20});
  board.device().send(random_image(random, 20, 56).view());
  board.finish();
  EXPECT_EQ(board.delivered(kImage), 10U);
  EXPECT_EQ(board.lost(kImage), 10U);
}

// All lines of the tallest raw image.
TEST(Board, RawImageOf1023Rows) {
  Random random(15);
  Scoreboard<Vboard> board({.bus_period_ps = 6000});
  board.write({.image = true, .columns = 64, .rows = spec::kMaxRows});
  for (int frame = 0; frame < 2; ++frame) {
    board.device().send(random_image(random, spec::kMaxRows, 64).view());
  }
  board.finish();
  EXPECT_EQ(board.delivered(kImage), 2U * static_cast<unsigned>(spec::kMaxRows));
  EXPECT_EQ(board.lost(kImage), 0U);
}

// More packets than any FIFO can count: twice as many as it has beats.
TEST(Board, PacketCountsGoAround) {
  Random random(16);
  Scoreboard<Vboard> board({.bus_period_ps = 6000});
  board.write({.image = true, .columns = 4, .rows = 1});
  for (int frame = 0; frame < 4200; ++frame) {
    board.device().send(random_image(random, 1, 4).view());
    board.device().gap(30);
  }
  board.finish();
  EXPECT_EQ(board.delivered(kMoments), 4200U);
  EXPECT_EQ(board.delivered(kImage), 4200U);
}

// The bus stands still. The FIFO keeps as many whole packets as fit; the others are lost, and the next header says how
// many.
TEST(OriginalBoard, OverflowDropsWholePacketsAndCountsThem) {
  Random random(8);
  Scoreboard<Vboard_original> board;
  board.write({.columns = 512, .rows = 4, .threshold = 100});
  board.device().set_bus_stall_percent(100);
  for (int frame = 0; frame < 10; ++frame) {
    board.device().send(random_image(random, 4, 512).view());
  }
  board.play();
  board.device().run(100);
  EXPECT_EQ(board.device().read(spec::kRegLostMoments), 7U) << "three packets of 133 beats fit into 512";
  board.device().set_bus_stall_percent(0);
  board.device().drain();
  EXPECT_EQ(board.delivered(kMoments), 3U);
  board.device().send(random_image(random, 4, 512).view());
  board.finish();
  EXPECT_EQ(board.delivered(kMoments), 4U);
  EXPECT_EQ(board.last_header(kMoments).lost, 7U);
  EXPECT_EQ(board.last_header(kMoments).sequence, 10U);
}

}  // namespace
}  // namespace selfproj::test
