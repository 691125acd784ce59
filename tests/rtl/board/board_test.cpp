// The whole board against the model, packet by packet and byte by byte.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "Vboard.h"
#include "Vboard_original.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr std::uint8_t kMoments = spec::kKindMoments;
constexpr std::uint8_t kImage = spec::kKindImage;

// What must lie between the starts of two frames beyond the beats of a moments packet (rtl/board/README.md).
int small_gap(Mode mode) { return mode == Mode::binary ? 8 : 14; }

void expect_plausible(const FrameCounts& counts) {
  std::printf("%llu frames, %llu packets delivered, %llu lost; %llu image lines delivered, %llu lost; %llu bytes\n",
              static_cast<unsigned long long>(counts.frames), static_cast<unsigned long long>(counts.delivered),
              static_cast<unsigned long long>(counts.lost), static_cast<unsigned long long>(counts.image_delivered),
              static_cast<unsigned long long>(counts.image_lost), static_cast<unsigned long long>(counts.bytes));
  if (runs_all_cases()) {
    EXPECT_GT(counts.delivered, counts.frames / 2) << "too little of the board was seen";
    EXPECT_GT(counts.lost, 0U) << "losses were not seen";
  }
}

// 10^5 frames in all with the tests of the small build and of faults below.
TEST(Board, RandomSmallFramesEqualTheModel) {
  FrameCounts counts;
  for (const std::uint64_t seed : seeds(80)) {
    SCOPED_TRACE(how_to_repeat(seed));
    play_random_frames<Vboard>(seed, {}, counts);
    if (HasFailure()) {
      return;
    }
  }
  expect_plausible(counts);
}

TEST(OriginalBoard, RandomSmallFramesEqualTheModel) {
  FrameCounts counts;
  for (const std::uint64_t seed : seeds(80)) {
    SCOPED_TRACE(how_to_repeat(seed));
    play_random_frames<Vboard_original>(seed, {.grey = false, .image = false}, counts);
    if (HasFailure()) {
      return;
    }
  }
  expect_plausible(counts);
}

// Lines of wrong length, missing, doubled, cut; starts missing or in mid-frame; pauses beyond the time-out.
TEST(Board, RandomFaultsEqualTheModel) {
  FrameCounts counts;
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    play_random_frames<Vboard>(seed, {.max_columns = 40, .max_rows = 12, .fault_percent = 40}, counts);
    if (HasFailure()) {
      return;
    }
  }
  expect_plausible(counts);
  if (runs_all_cases()) {
    for (const std::uint32_t status :
         {spec::kStatusShortLine, spec::kStatusLongLine, spec::kStatusStartInFrame, spec::kStatusIncomplete}) {
      EXPECT_GT(counts.by_status[status], 100U) << "status " << status;
    }
  }
}

TEST(OriginalBoard, RandomFaultsEqualTheModel) {
  FrameCounts counts;
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    play_random_frames<Vboard_original>(
        seed, {.max_columns = 40, .max_rows = 12, .grey = false, .image = false, .fault_percent = 40}, counts);
    if (HasFailure()) {
      return;
    }
  }
  expect_plausible(counts);
}

// Each fault in the first, a middle and the last row, each in the first, a middle and the last beat; the good frame
// that follows without a gap is delivered, with good status, and equal to the model's.
TEST(Board, TheFrameAfterAFaultIsRight) {
  Random random(7);
  constexpr int kRows = 24;
  constexpr int kColumns = 32;
  for (const Mode mode : {Mode::binary, Mode::grey_over}) {
    for (int fault = 0; fault < kFaults; ++fault) {
      for (const int row : {0, kRows / 2, kRows - 1}) {
        for (const int group : {0, kColumns / 8, kColumns / 4 - 1}) {
          SCOPED_TRACE(::testing::Message() << "fault " << fault << " in row " << row << ", beat " << group);
          Scoreboard<Vboard> board;
          board.write({.image = true, .columns = kColumns, .rows = kRows, .mode = mode, .threshold = 30});
          const auto send = [&](Fault what) {
            const TestImage image = random_image(random, kRows, kColumns);
            for (const VideoBeat& beat : with_fault(lines_of(image), what, row, group)) {
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

// The corners of the size range. 2048 x 1023 pixels of 255 need every bit of every sum.
TEST(Board, ExtremeSizesEqualTheModel) {
  Random random(11);
  for (const Mode mode : {Mode::binary, Mode::grey, Mode::grey_over}) {
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
      const bool bright = mode != Mode::grey_over;
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

// The thesis's frames: 200 of 96 x 512, stalls on both sides.
TEST(Board, FullFramesWithStallsEqualTheModel) {
  for (const std::uint64_t seed : seeds(1)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    Scoreboard<Vboard> board({.seed = seed, .bus_stall_percent = 40, .video_gap_percent = 15});
    board.turn_encoder(151);
    for (int frame = 0; frame < 200; ++frame) {
      if (frame % 20 == 0) {
        board.write({.image = frame % 40 == 0,
                     .columns = 512,
                     .rows = 96,
                     .mode = static_cast<Mode>(frame / 20 % 3),
                     .threshold = random.between(0, 255)});
      }
      board.device().send(random_image(random, 96, 512).view());
      board.play();
    }
    board.finish();
    EXPECT_EQ(board.delivered(kMoments), 200U);
    EXPECT_EQ(board.lost(kMoments), 0U);
  }
}

// 12,288 clocks a frame: every clock carries a beat, and nothing is lost, with raw images too.
TEST(Board, TakesFullFramesBackToBack) {
  Random random(3);
  for (const Mode mode : {Mode::binary, Mode::grey, Mode::grey_over}) {
    Scoreboard<Vboard> board({.bus_stall_percent = 20});
    board.write({.image = true, .columns = 512, .rows = 96, .mode = mode, .threshold = 100});
    const std::uint64_t before = board.device().clock();
    for (int frame = 0; frame < 12; ++frame) {
      board.device().send(random_image(random, 96, 512).view());
    }
    board.play();
    EXPECT_EQ(board.device().clock() - before, 12U * 12288U);
    board.finish();
    EXPECT_EQ(board.delivered(kMoments), 12U);
    EXPECT_EQ(board.lost(kMoments), 0U);
    EXPECT_EQ(board.delivered(kImage), 12U * 96U);
    EXPECT_EQ(board.lost(kImage), 0U);
  }
}

// Frames that follow each other by the beats of a packet and the stated small gap: none is lost; by one clock less:
// some are.
TEST(Board, SmallestDistanceOfFramesIsAsStated) {
  Random random(5);
  for (const Mode mode : {Mode::binary, Mode::grey}) {
    for (const auto& [columns, rows] :
         std::vector<std::pair<int, int>>{{4, 1}, {8, 2}, {40, 1}, {64, 2}, {512, 1}, {512, 2}, {1024, 1}}) {
      const int beats = columns / 4 * rows;
      const int distance = static_cast<int>(packet_beats(moments_payload_bytes(mode, columns))) + small_gap(mode);
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

// Lines of 60 columns and more follow each other without a gap; narrower ones are lost, and counted.
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

// All lines of the highest raw image.
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

// More packets than any FIFO counts to (as many as it has beats, twice).
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

// The bus stands still: as many packets as the FIFO holds are kept, whole; the rest is lost, and the next header says
// how many.
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

// A reset in every part of a frame: what comes after it is right, and counts from zero.
TEST(Board, ResetInMidFrame) {
  Random random(9);
  for (const Mode mode : {Mode::binary, Mode::grey}) {
    Scoreboard<Vboard> board;
    for (int clocks = 1; clocks < 420; clocks += 7) {
      board.write({.image = true, .columns = 64, .rows = 20, .mode = mode, .threshold = 100});
      board.device().send(random_image(random, 20, 64).view());
      board.device().run(static_cast<std::uint64_t>(clocks));
      board.reset();
      board.write({.image = true, .columns = 64, .rows = 20, .mode = mode, .threshold = 100});
      board.device().send(random_image(random, 20, 64).view());
      board.finish();
      ASSERT_EQ(board.delivered(kMoments), 1U) << clocks;
      ASSERT_EQ(board.last_header(kMoments).sequence, 0U) << clocks;
      ASSERT_EQ(board.delivered(kImage), 20U) << clocks;
    }
  }
}

// New settings written while a frame comes in: it keeps the old ones, the next has the new ones.
TEST(Board, SettingsChangeOnlyAtAFrameStart) {
  Random random(10);
  const std::vector<BoardSettings> all = {
      {.columns = 512, .rows = 12, .mode = Mode::binary, .threshold = 100, .stream = 1},
      {.columns = 256, .rows = 30, .mode = Mode::grey, .threshold = 50, .stream = 2},
      {.columns = 2048, .rows = 5, .mode = Mode::grey_over, .threshold = 7, .stream = 3},
      {.columns = 128, .rows = 40, .mode = Mode::grey_over, .threshold = 250, .stream = 4},
      {.columns = 1024, .rows = 6, .mode = Mode::grey, .threshold = 0, .stream = 5},
      {.columns = 512, .rows = 12, .mode = Mode::binary, .threshold = 0, .stream = 6},
  };
  Scoreboard<Vboard> board({.bus_period_ps = 6000});
  board.write(all.front());
  std::size_t now = 0;
  for (int frame = 0; frame < 60; ++frame) {
    board.device().send(random_image(random, all[now].rows, all[now].columns).view());
    // Into the frame, but not so far that it could end during the register accesses.
    while (board.device().queued() > static_cast<std::size_t>(all[now].columns / 4 * all[now].rows - 40)) {
      board.device().run(1);
    }
    now = (now + static_cast<std::size_t>(random.between(0, 3))) % all.size();
    board.write(all[now]);
    ASSERT_GT(board.device().queued(), 100U) << "the frame ended before the settings were written";
    EXPECT_EQ(board.device().read(spec::kRegStatus) & (1U << spec::kRegStatusPendingLsb),
              1U << spec::kRegStatusPendingLsb);
    EXPECT_EQ(board.device().read(spec::kRegStatus) & (1U << spec::kRegStatusFrameOpenLsb),
              1U << spec::kRegStatusFrameOpenLsb);
    board.play();
    board.device().run(600);  // a large frame in a grey mode is finished before one of another size begins
  }
  board.finish();
  EXPECT_EQ(board.delivered(kMoments), 60U);
  EXPECT_EQ(board.lost(kMoments), 0U);
}

// A large frame in a grey mode is still being finished when small ones come (the size changed): those that meet it are
// lost, counted, and nothing is wrong in the others.
TEST(Board, SmallFramesRightAfterALargeOne) {
  Random random(12);
  for (int rows = 1; rows < 12; ++rows) {
    for (const int columns : {4, 8, 12, 64}) {
      Scoreboard<Vboard> board({.bus_period_ps = 6000});
      const BoardSettings large = {.columns = 2048, .rows = 3, .mode = Mode::grey, .threshold = 9};
      const BoardSettings small = {.columns = columns, .rows = rows, .mode = Mode::grey, .threshold = 9};
      board.write(large);
      board.device().send(random_image(random, large.rows, large.columns).view());
      while (board.device().queued() > 1000) {
        board.device().run(1);
      }
      board.write(small);
      ASSERT_GT(board.device().queued(), 100U);
      for (int i = 0; i < 300; ++i) {
        board.device().send(random_image(random, rows, columns).view());
        board.device().gap(static_cast<std::uint32_t>(random.between(0, columns)));
      }
      board.finish();
      EXPECT_GT(board.lost(kMoments), 0U);
      EXPECT_GT(board.delivered(kMoments), 1U);
      ASSERT_FALSE(HasFailure()) << columns << " x " << rows;
    }
  }
}

// `run` decides at a frame's start: a frame that has begun is finished, one that begins while it is low is not seen at
// all.
TEST(Board, RunDecidesAtAFrameStart) {
  Random random(13);
  Scoreboard<Vboard> board;
  BoardSettings settings = {.run = true, .columns = 512, .rows = 12};
  board.write(settings);
  board.device().send(random_image(random, 12, 512).view());
  board.device().run(200);
  settings.run = false;
  board.write(settings);
  board.play();
  const TestImage unseen = random_image(random, 12, 512);
  std::size_t beats = 0;
  for (const auto& line : lines_of(unseen)) {
    for (const VideoBeat& beat : line) {
      if (beats++ == 600) {
        board.play();
        settings.run = true;
        board.write(settings);  // within the frame that was not accepted: its rest is discarded, and counted
      }
      board.device().send(beat);
    }
  }
  board.play();
  EXPECT_EQ(board.model().stray(), beats - 600);
  board.device().send(random_image(random, 12, 512).view());
  board.finish();
  EXPECT_EQ(board.delivered(kMoments), 2U);
  EXPECT_EQ(board.last_header(kMoments).flags, spec::kFlagStrayBefore);
}

// The trigger sequencer's index at the camera pulse travels with the frame that follows it.
TEST(Board, PatternIndexTravelsWithTheFrame) {
  Random random(14);
  BoardDevice<Vboard> device;
  std::vector<int> patterns;
  device.on_packet([&](std::span<const std::uint8_t> bytes) {
    PacketView view;
    ASSERT_EQ(parse_packet(bytes, view), PacketError::none);
    patterns.push_back(view.header.pattern);
  });
  device.write(BoardSettings{.columns = 32, .rows = 4});
  device.write(spec::kRegTriggerPeriod, 200);
  device.write(spec::kRegTriggerCamera, 20);
  device.write(spec::kRegTriggerWidth, 5);
  bool camera = false;
  int pulses = 0;
  device.on_clock([&](std::uint64_t) {
    const bool now = device.camera_trigger();
    if (now && !camera && pulses++ % 5 != 3) {  // the camera misses every fifth pulse
      device.gap(60);
      device.send(random_image(random, 4, 32).view());
    }
    camera = now;
  });
  device.write(spec::kRegTriggerControl,
               1U << spec::kRegTriggerControlRunLsb | 7U << spec::kRegTriggerControlLastPatternLsb);
  device.run(200 * 24 + 150);
  device.write(spec::kRegTriggerControl, 0);
  device.drain();
  std::vector<int> want;
  for (int pulse = 0; pulse < pulses; ++pulse) {
    if (pulse % 5 != 3) {
      want.push_back(pulse % 8);
    }
  }
  EXPECT_GE(pulses, 24);
  EXPECT_EQ(patterns, want);
}

// Small packets into a bus that stands still: each FIFO takes them to its last place, and none beyond; all that it took
// comes out whole.
TEST(Board, FifosFillToTheLastPlace) {
  constexpr std::size_t kMomentsPlaces = 2048;
  constexpr std::size_t kImagePlaces = 1024;
  Random random(17);
  for (const bool grey : {false, true}) {
    for (const int columns : {4, 16, 40}) {
      SCOPED_TRACE(::testing::Message() << columns << " columns");
      const Mode mode = grey ? Mode::grey : Mode::binary;
      Scoreboard<Vboard> board({.bus_period_ps = 6000});
      board.write({.image = true, .columns = columns, .rows = 2, .mode = mode, .threshold = 100});
      board.device().set_bus_stall_percent(100);
      for (int frame = 0; frame < 450; ++frame) {
        board.device().send(random_image(random, 2, columns).view());
        board.device().gap(60);
      }
      board.play();
      board.device().run(100);
      const auto moments = 450 - board.device().read(spec::kRegLostMoments);
      const auto lines = 900 - board.device().read(spec::kRegLostImage);
      board.device().set_bus_stall_percent(0);
      board.finish();
      EXPECT_EQ(board.delivered(kMoments), moments);
      EXPECT_EQ(board.delivered(kImage), lines);
      // One more would not have gone in. A few beats have left the FIFO for the arbiter.
      const std::size_t beats = packet_beats(moments_payload_bytes(mode, columns));
      const std::size_t line_beats = packet_beats(image_line_payload_bytes(columns));
      EXPECT_GT((moments + 1) * beats, kMomentsPlaces);
      EXPECT_LE(moments * beats, kMomentsPlaces + 8);
      EXPECT_GT((lines + 1) * line_beats, kImagePlaces);
      EXPECT_LE(lines * line_beats, kImagePlaces + 8);
    }
  }
}

// A pause within a frame as long as the time-out does no harm, one clock more breaks the frame: for every bit of the
// time-out that a run can wait for.
TEST(Board, EveryBitOfTheTimeOut) {
  Random random(18);
  for (int bits = 1; bits <= 19; ++bits) {
    const int timeout = (1 << (bits - 1)) + random.between(0, (1 << (bits - 1)) - 1);
    SCOPED_TRACE(::testing::Message() << "time-out " << timeout);
    Scoreboard<Vboard> board({.bus_period_ps = 6000});
    board.write({.columns = 16, .rows = 4, .threshold = 100, .timeout = timeout});
    for (const int more : {0, 1}) {
      const auto lines = lines_of(random_image(random, 4, 16));
      for (std::size_t row = 0; row < lines.size(); ++row) {
        if (row == 2) {
          board.device().gap(static_cast<std::uint32_t>(timeout + more));
        }
        for (const VideoBeat& beat : lines[row]) {
          board.device().send(beat);
        }
      }
      board.device().gap(100);
    }
    board.finish();
    EXPECT_EQ(board.model().broken(), 1U);
    if (HasFailure()) {
      return;
    }
  }
}

// Both lines of the encoder change at once: the register counts every time, and the camera is never held up.
TEST(Board, CountsTheEncodersErrors) {
  BoardDevice<Vboard> device({.bus_period_ps = 6000});
  bool never_held = true;
  device.on_clock([&](std::uint64_t) { never_held = never_held && device.takes_beats(); });
  device.run(100);
  std::uint32_t errors = 0;
  for (const std::uint32_t until : {3U, 12U, 340U, 1365U}) {
    while (errors < until) {
      ++errors;
      device.set_encoder(errors % 2 != 0, errors % 2 != 0);
      device.run(10);
    }
    EXPECT_EQ(device.read(spec::kRegEncoderErrors), errors);
  }
  EXPECT_EQ(device.read(spec::kRegEncoder), 0U);
  EXPECT_TRUE(never_held);
}

// Pulses of the trigger at the clocks that its settings say, for every bit of them that a run can wait for.
TEST(Board, EveryBitOfTheTriggersSettings) {
  Random random(19);
  for (int bits = 4; bits <= 17; ++bits) {
    BoardDevice<Vboard> device({.bus_period_ps = 6000});
    const auto period = static_cast<std::uint64_t>((1 << (bits - 1)) + random.between(0, (1 << (bits - 1)) - 1));
    const auto camera = static_cast<std::uint64_t>(random.between(1, static_cast<int>(period) - 1));
    const auto width = static_cast<std::uint64_t>(random.between(1, std::min(static_cast<int>(period) - 1, 0xFFFF)));
    SCOPED_TRACE(::testing::Message() << "period " << period << ", camera " << camera << ", width " << width);
    device.write(BoardSettings{.columns = 32, .rows = 4});
    device.write(spec::kRegTriggerPeriod, static_cast<std::uint32_t>(period));
    device.write(spec::kRegTriggerCamera, static_cast<std::uint32_t>(camera));
    device.write(spec::kRegTriggerWidth, static_cast<std::uint32_t>(width));
    std::array<bool, 2> level = {};
    std::array<std::vector<std::uint64_t>, 2> rises;
    std::array<std::vector<std::uint64_t>, 2> falls;
    device.on_clock([&](std::uint64_t clock) {
      const std::array<bool, 2> now = {device.projector_trigger(), device.camera_trigger()};
      for (std::size_t line = 0; line < 2; ++line) {
        if (now.at(line) != level.at(line)) {
          (now.at(line) ? rises : falls).at(line).push_back(clock);
        }
      }
      level = now;
    });
    device.write(spec::kRegTriggerControl, 1U << spec::kRegTriggerControlRunLsb);
    device.run(3 * period + 100);
    for (std::size_t line = 0; line < 2; ++line) {
      ASSERT_GE(rises.at(line).size(), 3U);
      ASSERT_GE(falls.at(line).size(), 2U);
      for (std::size_t pulse = 0; pulse < 2; ++pulse) {
        EXPECT_EQ(rises.at(line).at(pulse + 1) - rises.at(line).at(pulse), period);
        EXPECT_EQ(falls.at(line).at(pulse) - rises.at(line).at(pulse), width);
      }
    }
    EXPECT_EQ(rises[1][0] - rises[0][0], camera);
    if (HasFailure()) {
      return;
    }
  }
}

// What identifies the board stands in its registers.
template <class Model>
void expect_identity(int max_columns, int max_rows, bool grey, bool image) {
  BoardDevice<Model> device;
  EXPECT_EQ(device.read(spec::kRegId), spec::kMagic);
  EXPECT_EQ(device.read(spec::kRegVersion), spec::kVersion);
  EXPECT_EQ(device.read(spec::kRegSpecHash), spec::kHash);
  const std::uint32_t capability = device.read(spec::kRegCapability);
  EXPECT_EQ(capability >> spec::kRegCapabilityMaxColumnsLsb & 0xFFFU, static_cast<unsigned>(max_columns));
  EXPECT_EQ(capability >> spec::kRegCapabilityMaxRowsLsb & 0x3FFU, static_cast<unsigned>(max_rows));
  EXPECT_EQ((capability >> spec::kRegCapabilityGreyLsb & 1U) != 0, grey);
  EXPECT_EQ((capability >> spec::kRegCapabilityImageLsb & 1U) != 0, image);
}

// Where no register is, reads and writes are refused.
TEST(Board, RefusesWhereNoRegisterIs) {
  BoardDevice<Vboard> device;
  constexpr std::uint32_t kNowhere = 0xFC;
  EXPECT_TRUE(device.access(false, kNowhere, 0).error);
  EXPECT_TRUE(device.access(true, kNowhere, 1).error);
  EXPECT_FALSE(device.access(false, spec::kRegId, 0).error);
}

TEST(Board, SaysWhatItIs) { expect_identity<Vboard>(spec::kMaxColumns, spec::kMaxRows, true, true); }
TEST(OriginalBoard, SaysWhatItIs) { expect_identity<Vboard_original>(512, 127, false, false); }

}  // namespace
}  // namespace selfproj::test
