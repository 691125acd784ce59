// Compares every output of the frame tracker in every clock with a reference: good frames of every shape, every kind of
// broken frame, settings that change at any time, and time-outs.
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "tests/rtl/blocks/frame_tracker_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::frame_tracker {
namespace {

TEST(FrameTracker, GoodFramesOfEveryShape) {
  Random random(1);
  std::vector<std::array<int, 2>> sizes = {{2048, 2}, {4, 1023}, {8, 1023}, {2044, 1}, {1024, 3}, {512, 96}};
  for (int columns = 4; columns <= 40; columns += 4) {
    for (int rows = 1; rows <= 6; ++rows) {
      sizes.push_back({columns, rows});
    }
  }
  for (const auto& size : sizes) {
    SCOPED_TRACE(::testing::Message() << size[0] << " x " << size[1]);
    FrameTrackerBench bench;
    bench.idle(2);
    bench.set(
        {random.chance(50), size[0], size[1], random.between(0, 2), random.between(0, 255), random.between(0, 255)});
    bench.idle(5);
    for (int frame = 0; frame < 5; ++frame) {
      good_frame(bench, random, frame < 3 ? 0 : 40);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    bench.idle(4);
    EXPECT_EQ(bench.broken(), 0U);
    EXPECT_EQ(bench.reference().stray, 0U);
  }
}

// A gap of timeout_i clocks is allowed; with one more the frame has ended.
TEST(FrameTracker, TimeOutAfterExactlySoManyClocks) {
  for (const int timeout : {1, 2, 3, 10, 300, 70000}) {
    for (int more = 0; more < 2; ++more) {
      SCOPED_TRACE(::testing::Message() << timeout << " + " << more);
      FrameTrackerBench bench;
      bench.timeout = timeout;
      bench.set({false, 8, 2, 0, 0, 0});
      bench.idle(5);
      bench.clock(Beat{1, true, false});
      bench.idle(timeout + more);
      bench.clock(Beat{2, false, true});
      bench.clock(Beat{3, false, false});
      bench.clock(Beat{4, false, true});
      bench.idle(5);
      EXPECT_EQ(bench.broken(), static_cast<std::uint32_t>(more));
      EXPECT_EQ(bench.reference().stray, more == 0 ? 0U : 3U);
    }
  }
}

// Time-outs with a single bit set.
TEST(FrameTracker, LongTimeOutsToTheClock) {
  std::vector<int> timeouts;
  for (int bit = 5; bit < 24; ++bit) {
    timeouts.push_back(1 << bit);
  }
  // around and just below the carry into the upper half of the counter
  timeouts.insert(timeouts.end(), {0xFFF, 0x1001, 0x1FC0, 0x1FFF, 0x2FBF});
  for (const int timeout : timeouts) {
    SCOPED_TRACE(::testing::Message() << "time-out " << timeout);
    FrameTrackerBench bench;
    bench.timeout = timeout;
    bench.set({false, 8, 2, 0, 0, 0});
    bench.idle(5);
    bench.clock(Beat{1, true, false});
    bench.wait(bench.timeout);
    ASSERT_FALSE(::testing::Test::HasFatalFailure());
    EXPECT_TRUE(bench.reference().open);
    bench.idle(5);
    EXPECT_EQ(bench.broken(), 1U);
  }
}

// Without a time-out a frame stays open for longer than the longest time-out.
TEST(FrameTracker, NoTimeOutIsNever) {
  FrameTrackerBench bench;
  bench.set({false, 8, 2, 0, 0, 0});
  bench.idle(5);
  bench.clock(Beat{1, true, false});
  bench.wait((1 << 24) + 100);
  EXPECT_TRUE(bench.reference().open);
  EXPECT_EQ(bench.broken(), 0U);
}

// Enough events to use the upper half of the counters.
TEST(FrameTracker, ManyBrokenFramesAndStrayBeatsAreCounted) {
  constexpr std::uint32_t kMany = 70'000;
  FrameTrackerBench bench;
  bench.set({false, 8, 2, 0, 0, 0});
  bench.idle(5);
  for (std::uint32_t i = 0; i < kMany; ++i) {
    bench.clock(Beat{i, true, false});  // each except the first breaks the previous frame
    ASSERT_FALSE(::testing::Test::HasFatalFailure());
  }
  for (std::uint32_t i = 0; i < kMany; ++i) {
    bench.clock(Beat{i, false, false});  // the first one breaks the last frame
    ASSERT_FALSE(::testing::Test::HasFatalFailure());
  }
  bench.idle(4);
  EXPECT_EQ(bench.broken(), kMany);
  EXPECT_EQ(bench.reference().stray, kMany - 1);
}

// Settings are written while frames follow each other; take-overs are at least seven clocks apart.
TEST(FrameTracker, SettingsChangeAtAFramesStartOnly) {
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    FrameTrackerBench bench;
    bench.idle(3);
    // the camera follows the settings in force, so that the frames are good
    for (int frame = 0; frame < 60; ++frame) {
      Settings s = bench.settings;
      if (random.chance(60)) {
        s = {random.chance(50),
             4 * random.between(1, 4),
             random.between(1, 4),
             random.between(0, 2),
             random.between(0, 255),
             random.between(0, 255),
             static_cast<std::uint32_t>(random.between(0, (1 << 23) - 1))};
      }
      bench.set(s);
      bench.hold = random.chance(20) && bench.reference().taken;
      bench.idle(random.between(2, 8));
      good_frame(bench, random, random.chance(50) ? 0 : 30);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
  }
}

// Beats with tuser and tlast anywhere, gaps, and changes of settings and run_i at any time: every output equals the
// reference.
TEST(FrameTracker, BrokenInputOfEveryKind) {
  for (const std::uint64_t seed : seeds(150)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    FrameTrackerBench bench;
    const int gaps = random.chance(50) ? 0 : random.between(1, 70);
    const int errors = random.between(0, 15);
    bench.timeout = random.chance(40) ? 0 : random.between(1, random.chance(90) ? 8 : 0xFFFFFF);
    bench.set({false, 4 * random.between(1, 5), random.between(1, 5), 0, 0, 0});
    bench.idle(random.between(0, 6));
    int group = 0;
    int row = 1;
    for (int i = 0; i < 2500; ++i) {
      if (random.chance(1)) {
        bench.run = random.chance(80);
      }
      if (random.chance(2)) {
        bench.hold = random.chance(40);
      }
      if (random.chance(1)) {
        bench.set({random.chance(50), 4 * random.between(1, 5), random.between(1, 5), random.between(0, 2),
                   random.between(0, 255), random.between(0, 255)});
        bench.timeout = random.chance(40) ? 0 : random.between(1, random.chance(90) ? 8 : 0xFFFFFF);
      }
      if (random.chance(gaps)) {
        bench.clock(std::nullopt);
      } else {
        // a camera that mostly sends the frames asked for
        const int groups = bench.settings.columns / 4;
        Beat beat = {static_cast<std::uint32_t>(random.bits()), row == 1 && group == 0, group >= groups - 1};
        if (random.chance(errors)) {
          beat.last = !beat.last;
        }
        if (random.chance(errors)) {
          beat.user = !beat.user;
        }
        bench.clock(beat);
        group = beat.last ? 0 : group + 1;
        row = beat.last ? row + 1 : row;
        if (row > bench.settings.rows) {
          row = 1;
        }
      }
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
      if (random.chance(errors) && random.chance(10)) {  // a pause: a time-out if one is set
        bench.idle(random.between(1, 12));
      }
    }
    bench.idle(12);
  }
}

}  // namespace
}  // namespace selfproj::test::frame_tracker
