// Tests the control of the board, and when settings take effect: reset, settings, run, pattern index, FIFO depth,
// time-out, encoder, trigger, and the registers that describe the build.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "Vboard.h"
#include "Vboard_original.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// A reset in every part of a frame: everything after it is right, and counts from zero.
TEST(Board, ResetInMidFrame) {
  Random random(9);
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey}) {
    Scoreboard<Vboard> board;
    for (int clocks = 1; clocks < 420; clocks += 7) {
      board.write({.image = true, .columns = 64, .rows = 20, .mode = mode, .threshold = 100});
      board.device().send(random_image(random, 20, 64).view());
      board.device().run(static_cast<std::uint64_t>(clocks));
      board.reset();
      board.write({.image = true, .columns = 64, .rows = 20, .mode = mode, .threshold = 100});
      board.device().send(random_image(random, 20, 64).view());
      board.finish();
      ASSERT_EQ(board.delivered(spec::kKindMoments), 1U) << clocks;
      ASSERT_EQ(board.last_header(spec::kKindMoments).sequence, 0U) << clocks;
      ASSERT_EQ(board.delivered(spec::kKindImage), 20U) << clocks;
    }
  }
}

// New settings are written while a frame comes in. It keeps the old ones; the next frame has the new ones.
TEST(Board, SettingsChangeOnlyAtAFrameStart) {
  Random random(10);
  const std::vector<model::BoardSettings> all = {
      {.columns = 512, .rows = 12, .mode = model::Mode::binary, .threshold = 100, .stream = 1},
      {.columns = 256, .rows = 30, .mode = model::Mode::grey, .threshold = 50, .stream = 2},
      {.columns = 2048, .rows = 5, .mode = model::Mode::grey_over, .threshold = 7, .stream = 3},
      {.columns = 128, .rows = 40, .mode = model::Mode::grey_over, .threshold = 250, .stream = 4},
      {.columns = 1024, .rows = 6, .mode = model::Mode::grey, .threshold = 0, .stream = 5},
      {.columns = 512, .rows = 12, .mode = model::Mode::binary, .threshold = 0, .stream = 6},
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
    board.device().run(600);  // a large frame in a grey mode is complete before one of another size begins
  }
  board.finish();
  EXPECT_EQ(board.delivered(spec::kKindMoments), 60U);
  EXPECT_EQ(board.lost(spec::kKindMoments), 0U);
}

// The size changes, and small frames come while a large frame in a grey mode still drains. Those that collide with it
// are lost and counted; the others are right.
TEST(Board, SmallFramesRightAfterALargeOne) {
  Random random(12);
  for (int rows = 1; rows < 12; ++rows) {
    for (const int columns : {4, 8, 12, 64}) {
      Scoreboard<Vboard> board({.bus_period_ps = 6000});
      const model::BoardSettings large = {.columns = 2048, .rows = 3, .mode = model::Mode::grey, .threshold = 9};
      const model::BoardSettings small = {.columns = columns, .rows = rows, .mode = model::Mode::grey, .threshold = 9};
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
      EXPECT_GT(board.lost(spec::kKindMoments), 0U);
      EXPECT_GT(board.delivered(spec::kKindMoments), 1U);
      ASSERT_FALSE(HasFailure()) << columns << " x " << rows;
    }
  }
}

// `run` counts at the start of a frame. A frame that has begun is completed; a frame that begins while `run` is low is
// ignored.
TEST(Board, RunDecidesAtAFrameStart) {
  Random random(13);
  Scoreboard<Vboard> board;
  model::BoardSettings settings = {.run = true, .columns = 512, .rows = 12};
  board.write(settings);
  board.device().send(random_image(random, 12, 512).view());
  board.device().run(200);
  settings.run = false;
  board.write(settings);
  board.play();
  const TestImage unseen = random_image(random, 12, 512);
  std::size_t beats = 0;
  for (const auto& line : lines_of(unseen)) {
    for (const model::VideoBeat& beat : line) {
      if (beats++ == 600) {
        board.play();
        settings.run = true;
        board.write(settings);  // within the frame that was not accepted: its rest is discarded and counted
      }
      board.device().send(beat);
    }
  }
  board.play();
  EXPECT_EQ(board.model().stray(), beats - 600);
  board.device().send(random_image(random, 12, 512).view());
  board.finish();
  EXPECT_EQ(board.delivered(spec::kKindMoments), 2U);
  EXPECT_EQ(board.last_header(spec::kKindMoments).flags, spec::kFlagStrayBefore);
}

// The trigger sequencer's index at the camera pulse travels with the frame that follows it.
TEST(Board, PatternIndexTravelsWithTheFrame) {
  Random random(14);
  sim::BoardDevice<Vboard> device;
  std::vector<int> patterns;
  device.on_packet([&](std::span<const std::uint8_t> bytes) {
    model::PacketView view;
    ASSERT_EQ(model::parse_packet(bytes, view), model::PacketError::none);
    patterns.push_back(view.header.pattern);
  });
  device.write(model::BoardSettings{.columns = 32, .rows = 4});
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

// Small packets while the bus stands still. Each FIFO takes them until it is full and no further; all packets that it
// took come out whole.
TEST(Board, FifosFillToTheLastPlace) {
  constexpr std::size_t kMomentsPlaces = 2048;
  constexpr std::size_t kImagePlaces = 1024;
  Random random(17);
  for (const bool grey : {false, true}) {
    for (const int columns : {4, 16, 40}) {
      SCOPED_TRACE(::testing::Message() << columns << " columns");
      const model::Mode mode = grey ? model::Mode::grey : model::Mode::binary;
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
      EXPECT_EQ(board.delivered(spec::kKindMoments), moments);
      EXPECT_EQ(board.delivered(spec::kKindImage), lines);
      // One more would not have fitted. A few beats have left the FIFO for the arbiter.
      const std::size_t beats = packet_beats(model::moments_payload_bytes(mode, columns));
      const std::size_t line_beats = packet_beats(model::image_line_payload_bytes(columns));
      EXPECT_GT((moments + 1) * beats, kMomentsPlaces);
      EXPECT_LE(moments * beats, kMomentsPlaces + 8);
      EXPECT_GT((lines + 1) * line_beats, kImagePlaces);
      EXPECT_LE(lines * line_beats, kImagePlaces + 8);
    }
  }
}

// A pause as long as the time-out does no harm; one clock more breaks the frame. This holds for every bit of the
// time-out for which a run can wait.
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
        for (const model::VideoBeat& beat : lines[row]) {
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

// Both lines of the encoder change in the same clock: the register counts every time, and the camera is never held up.
TEST(Board, CountsTheEncodersErrors) {
  sim::BoardDevice<Vboard> device({.bus_period_ps = 6000});
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

// The trigger pulses in the clocks that its settings give, for every bit for which a run can wait.
TEST(Board, EveryBitOfTheTriggersSettings) {
  Random random(19);
  for (int bits = 4; bits <= 17; ++bits) {
    sim::BoardDevice<Vboard> device({.bus_period_ps = 6000});
    const auto period = static_cast<std::uint64_t>((1 << (bits - 1)) + random.between(0, (1 << (bits - 1)) - 1));
    const auto camera = static_cast<std::uint64_t>(random.between(1, static_cast<int>(period) - 1));
    const auto width = static_cast<std::uint64_t>(random.between(1, std::min(static_cast<int>(period) - 1, 0xFFFF)));
    SCOPED_TRACE(::testing::Message() << "period " << period << ", camera " << camera << ", width " << width);
    device.write(model::BoardSettings{.columns = 32, .rows = 4});
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

// Writes to the settings of the sequencer while it runs are refused: every pulse comes as before, and no index is
// beyond the last. After a stop they count.
TEST(Board, TheTriggersSettingsStandStillWhileItRuns) {
  sim::BoardDevice<Vboard> device({.bus_period_ps = 6000});
  const auto refused = [&](std::uint32_t address, std::uint32_t data) {
    return device.access(true, address, data).error;
  };
  const auto control = [](std::uint32_t last_pattern) {
    return 1U << spec::kRegTriggerControlRunLsb | last_pattern << spec::kRegTriggerControlLastPatternLsb;
  };
  constexpr std::uint64_t kPeriod = 300;
  std::array<std::vector<std::uint64_t>, 2> rises;
  std::array<bool, 2> level = {};
  device.on_clock([&](std::uint64_t clock) {
    const std::array<bool, 2> now = {device.projector_trigger(), device.camera_trigger()};
    for (std::size_t line = 0; line < 2; ++line) {
      if (now.at(line) && !level.at(line)) {
        rises.at(line).push_back(clock);
        if (line == 1) {
          device.send({.pixels = {1, 2, 3, 4}, .start = true, .line_end = true});
        }
      }
    }
    level = now;
  });
  std::vector<int> patterns;
  device.on_packet([&](std::span<const std::uint8_t> bytes) {
    model::PacketView view;
    ASSERT_EQ(model::parse_packet(bytes, view), model::PacketError::none);
    patterns.push_back(view.header.pattern);
  });
  device.write(model::BoardSettings{.columns = 4, .rows = 1});
  device.write(spec::kRegTriggerPeriod, kPeriod);
  device.write(spec::kRegTriggerCamera, 100);
  device.write(spec::kRegTriggerWidth, 10);
  device.write(spec::kRegTriggerControl, control(7));
  device.run(kPeriod * 5);  // the index is above 3
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(refused(spec::kRegTriggerControl, control(3)));
    EXPECT_TRUE(refused(spec::kRegTriggerPeriod, 20));
    EXPECT_TRUE(refused(spec::kRegTriggerCamera, 5));
    EXPECT_TRUE(refused(spec::kRegTriggerWidth, 0));
    device.run(37);
  }
  EXPECT_EQ(device.read(spec::kRegTriggerPeriod), kPeriod);
  EXPECT_EQ(device.read(spec::kRegTriggerControl), control(7));
  for (const auto& times : rises) {
    ASSERT_GE(times.size(), 10U);
    for (std::size_t pulse = 1; pulse < times.size(); ++pulse) {
      ASSERT_EQ(times[pulse] - times[pulse - 1], kPeriod) << "pulse " << pulse;
    }
  }
  device.write(spec::kRegTriggerControl, 0);
  device.drain();
  for (std::size_t frame = 0; frame < patterns.size(); ++frame) {
    ASSERT_EQ(patterns[frame], static_cast<int>(frame % 8)) << "frame " << frame;
  }
  EXPECT_GE(patterns.size(), 10U);

  rises = {};
  device.write(spec::kRegTriggerPeriod, 40);
  device.write(spec::kRegTriggerCamera, 5);
  device.write(spec::kRegTriggerControl, control(3));
  device.run(400);
  ASSERT_GE(rises[0].size(), 5U);
  EXPECT_EQ(rises[0][4] - rises[0][3], 40U);
  EXPECT_EQ(rises[1][4] - rises[0][4], 5U);
}

// The registers identify the board.
template <class Model>
void expect_identity(int max_columns, int max_rows, bool grey, bool image) {
  sim::BoardDevice<Model> device;
  EXPECT_EQ(device.read(spec::kRegId), spec::kMagic);
  EXPECT_EQ(device.read(spec::kRegVersion), spec::kVersion);
  EXPECT_EQ(device.read(spec::kRegSpecHash), spec::kHash);
  const std::uint32_t capability = device.read(spec::kRegCapability);
  EXPECT_EQ(capability >> spec::kRegCapabilityMaxColumnsLsb & 0xFFFU, static_cast<unsigned>(max_columns));
  EXPECT_EQ(capability >> spec::kRegCapabilityMaxRowsLsb & 0x3FFU, static_cast<unsigned>(max_rows));
  EXPECT_EQ((capability >> spec::kRegCapabilityGreyLsb & 1U) != 0, grey);
  EXPECT_EQ((capability >> spec::kRegCapabilityImageLsb & 1U) != 0, image);
}

// Reads and writes of addresses without a register are refused.
TEST(Board, RefusesWhereNoRegisterIs) {
  sim::BoardDevice<Vboard> device;
  constexpr std::uint32_t kNowhere = 0xFC;
  EXPECT_TRUE(device.access(false, kNowhere, 0).error);
  EXPECT_TRUE(device.access(true, kNowhere, 1).error);
  EXPECT_FALSE(device.access(false, spec::kRegId, 0).error);
}

TEST(Board, SaysWhatItIs) { expect_identity<Vboard>(spec::kMaxColumns, spec::kMaxRows, true, true); }
TEST(OriginalBoard, SaysWhatItIs) { expect_identity<Vboard_original>(512, 127, false, false); }

}  // namespace
}  // namespace selfproj::test
