// Compares every output of the frame tracker in every clock with a reference: good frames of every shape, every kind of
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "Vsp_frame_tracker_ports.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::frame_tracker {
namespace {

struct Beat {
  std::uint32_t pixels = 0;
  bool user = false;
  bool last = false;
};

struct Settings {
  bool image = false;
  int columns = 4;
  int rows = 1;
  int mode = 0;
  int threshold = 0;
  int stream = 0;
  std::uint32_t select = 0;
  std::uint32_t region = 0;
  bool compact = false;
  int verdict = 0;
};

// All outputs in one clock. Fields of a beat count only if beat is set, those of a break only if break_status is set.
struct Outputs {
  bool take = false;
  std::optional<Beat> beat;
  int group = 0;
  int row = 0;
  bool first_row = false, last_row = false, line_start = false, line_end = false;
  bool frame_start = false;
  bool last_row_start = false;
  std::optional<std::uint32_t> break_status;
  bool break_in_last_row = false;
};

// Steps through the clocks. Like the tracker it knows the beat of the previous clock and the settings of this one.
class Reference {
 public:
  // Skips this many clocks in which no beat came and nothing happened.
  void pass(int clocks) {
    empty_clocks_ += clocks;
    clocks_since_take_ += clocks;
  }

  // Returns the outputs of the next clock, given the beat at the input in the previous clock.
  Outputs step(const std::optional<Beat>& beat, bool run, bool hold, const Settings& settings, int timeout) {
    Outputs out;
    // The decision whether a frame may start and take settings over was made two clocks ago.
    const Permit permit = permits_[0];
    permits_[0] = permits_[1];
    ++clocks_since_take_;
    out.break_status = late_break_;
    out.break_in_last_row = late_in_last_row_;
    late_break_.reset();
    if (beat) {
      empty_clocks_ = 0;
      timeout_ = timeout_before_;
      if (beat->user) {
        if (open) {  // the next frame starts before this one is complete
          out.break_status = spec::kStatusStartInFrame;
          out.break_in_last_row = last_row_begun_;
          open = false;
        }
        if (permit.start) {
          start(permit.take, settings, out);
        }
      }
      if (open) {
        take_beat(*beat, out);
      } else if (!out.beat && run) {
        ++stray;
        stray_flag_ = true;
      }
    } else if (++empty_clocks_ == timeout_ + 1 && timeout_ != 0 && open) {
      open = false;
      late_break_ = spec::kStatusIncomplete;
      late_in_last_row_ = last_row_begun_;
    }
    permits_[1] = {.start = run && (!hold || taken), .take = run && !hold};
    timeout_before_ = timeout;
    return out;
  }

  Settings in_force;
  bool taken = false;  // settings have been taken over
  bool open = false;
  bool stray_before = false;
  bool started = false;  // a frame has been accepted
  std::uint32_t stray = 0;

 private:
  void start(bool may_take, const Settings& settings, Outputs& out) {
    if (may_take && clocks_since_take_ > 6) {
      in_force = settings;
      taken = true;
      out.take = true;
      clocks_since_take_ = 0;
    }
    open = true;
    started = true;
    row_ = 1;
    group_ = 0;
    stray_before = stray_flag_;
    stray_flag_ = false;
    out.frame_start = true;
  }

  void take_beat(const Beat& beat, Outputs& out) {
    const bool line_complete = group_ == in_force.columns / 4 - 1;
    out.beat = beat;
    out.group = group_;
    out.row = row_;
    out.first_row = row_ == 1;
    out.last_row = row_ == in_force.rows;
    out.line_start = group_ == 0;
    out.line_end = line_complete && beat.last;
    out.last_row_start = out.last_row && out.line_start;
    last_row_begun_ = out.last_row;
    if (line_complete != beat.last) {
      late_break_ = beat.last ? spec::kStatusShortLine : spec::kStatusLongLine;
      late_in_last_row_ = out.last_row;
      open = false;
    } else if (line_complete) {
      open = !out.last_row;
      ++row_;
      group_ = 0;
    } else {
      ++group_;
    }
  }

  struct Permit {
    bool start = false;
    bool take = false;
  };

  std::array<Permit, 2> permits_;
  int row_ = 1;
  int group_ = 0;
  bool last_row_begun_ = false;
  bool stray_flag_ = false;
  int empty_clocks_ = 0;
  int timeout_ = 0;         // beside the last beat
  int timeout_before_ = 0;  // a clock ago
  int clocks_since_take_ = 100;
  std::optional<std::uint32_t> late_break_;
  bool late_in_last_row_ = false;
};

class FrameTrackerBench {
 public:
  FrameTrackerBench() {
    const auto beat = [this] { return tracker_->beat_valid_o != 0; };
    tracker_.valid_when({"beat_pixels_o", "beat_group_o", "beat_row_o", "beat_first_row_o", "beat_last_row_o",
                         "beat_line_start_o", "beat_line_end_o"},
                        beat);
    tracker_.valid_when({"break_in_last_row_o", "break_status_o"}, [this] { return tracker_->break_o != 0; });
    tracker_.valid_when({"image_o", "columns_o", "rows_o", "mode_o", "threshold_o", "stream_o", "select_o", "region_o",
                         "compact_o", "verdict_o", "one_group_o", "two_groups_o"},
                        [this] { return reference_.taken; });
    tracker_->s_axis_tvalid_i = 0;
    tracker_->run_i = 0;
    tracker_->hold_i = 1;
    set_inputs();
    tracker_.reset();
  }

  bool run = true;
  bool hold = false;
  Settings settings;
  int timeout = 0;

  // Settings come with hold_i in their first clock and in the two clocks before.
  void set(const Settings& now) {
    announced_ = now;
    held_ = 3;
  }

  void clock(const std::optional<Beat>& beat) {
    tracker_->s_axis_tvalid_i = beat.has_value();
    if (beat) {
      tracker_->s_axis_tdata_i = beat->pixels;
      tracker_->s_axis_tuser_i = beat->user;
      tracker_->s_axis_tlast_i = beat->last;
    }
    if (held_ == 1) {
      settings = announced_;
    }
    set_inputs();
    tracker_.settle();
    check();
    expected_ = reference_.step(before_, run, hold || held_ > 0, settings, timeout);
    if (broke_) {
      ++broken_;
    }
    broke_ = expected_.break_status.has_value();
    before_ = beat;
    held_ = std::max(held_ - 1, 0);
    tracker_.rise();
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks; ++i) {
      clock(std::nullopt);
    }
  }

  // The same, but except in the first and the last eight clocks it checks only that the frame stays open.
  void wait(int clocks) {
    idle(8);
    for (int i = 8; i < clocks - 8; ++i) {
      tracker_.settle();
      if (tracker_->frame_open_o == 0 || tracker_->break_o != 0) {
        FAIL() << "ended in clock " << i << " of " << clocks;
      }
      tracker_.rise();
    }
    reference_.pass(clocks - 16);
    idle(8);
  }

  std::uint32_t broken() const { return broken_; }
  const Reference& reference() const { return reference_; }
  std::int64_t now() const { return tracker_.clock(); }

 private:
  void set_inputs() {
    tracker_->run_i = run;
    tracker_->hold_i = hold || held_ > 0;
    tracker_->image_i = settings.image;
    tracker_->columns_i = static_cast<SData>(settings.columns);
    tracker_->rows_i = static_cast<SData>(settings.rows);
    tracker_->mode_i = static_cast<CData>(settings.mode);
    tracker_->threshold_i = static_cast<CData>(settings.threshold);
    tracker_->stream_i = static_cast<CData>(settings.stream);
    tracker_->select_i = settings.select;
    tracker_->region_i = settings.region;
    tracker_->compact_i = settings.compact;
    tracker_->verdict_i = static_cast<CData>(settings.verdict);
    tracker_->timeout_i = static_cast<IData>(timeout);
  }

  void check() {
    SCOPED_TRACE(::testing::Message() << "clock " << tracker_.clock());
    const Outputs& want = expected_;
    ASSERT_EQ(tracker_->s_axis_tready_o, 1);
    ASSERT_EQ(tracker_->take_o, want.take);
    ASSERT_EQ(tracker_->beat_valid_o, want.beat.has_value());
    ASSERT_EQ(tracker_->frame_start_o, want.frame_start);
    ASSERT_EQ(tracker_->last_row_start_o, want.last_row_start);
    if (want.beat) {
      ASSERT_EQ(tracker_->beat_pixels_o, want.beat->pixels);
      ASSERT_EQ(tracker_->beat_group_o, want.group);
      ASSERT_EQ(tracker_->beat_row_o, want.row);
      ASSERT_EQ(tracker_->beat_first_row_o, want.first_row);
      ASSERT_EQ(tracker_->beat_last_row_o, want.last_row);
      ASSERT_EQ(tracker_->beat_line_start_o, want.line_start);
      ASSERT_EQ(tracker_->beat_line_end_o, want.line_end);
    }
    ASSERT_EQ(tracker_->break_o, want.break_status.has_value());
    if (want.break_status) {
      ASSERT_EQ(tracker_->break_status_o, *want.break_status);
      ASSERT_EQ(tracker_->break_in_last_row_o, want.break_in_last_row);
    }
    ASSERT_EQ(tracker_->frame_open_o, reference_.open);
    // counted one clock later, and shown in the next
    ASSERT_EQ(tracker_->broken_o, broken_before_);
    ASSERT_EQ(tracker_->stray_o, stray_before_[0]);
    broken_before_ = broken_;
    stray_before_ = {stray_before_[1], reference_.stray};
    if (reference_.started) {
      ASSERT_EQ(tracker_->stray_before_o, reference_.stray_before);
    }
    if (reference_.taken) {
      ASSERT_EQ(tracker_->columns_o, reference_.in_force.columns);
      ASSERT_EQ(tracker_->rows_o, reference_.in_force.rows);
      ASSERT_EQ(tracker_->image_o, reference_.in_force.image);
      ASSERT_EQ(tracker_->mode_o, reference_.in_force.mode);
      ASSERT_EQ(tracker_->threshold_o, reference_.in_force.threshold);
      ASSERT_EQ(tracker_->stream_o, reference_.in_force.stream);
      ASSERT_EQ(tracker_->select_o, reference_.in_force.select);
      ASSERT_EQ(tracker_->region_o, reference_.in_force.region);
      ASSERT_EQ(tracker_->compact_o, reference_.in_force.compact);
      ASSERT_EQ(tracker_->verdict_o, reference_.in_force.verdict);
      ASSERT_EQ(tracker_->one_group_o, reference_.in_force.columns == 4);
      ASSERT_EQ(tracker_->two_groups_o, reference_.in_force.columns == 8);
    }
  }

  Clocked<Vsp_frame_tracker> tracker_;
  Reference reference_;
  Outputs expected_;
  std::optional<Beat> before_;
  Settings announced_;
  int held_ = 1;  // clocks for which hold_i is high regardless of `hold`, also in reset
  bool broke_ = false;
  std::uint32_t broken_ = 0;
  std::uint32_t broken_before_ = 0;              // a clock ago
  std::array<std::uint32_t, 2> stray_before_{};  // two clocks ago, one
};

// A good frame of the settings, gaps in percent.
void good_frame(FrameTrackerBench& bench, Random& random, int gaps) {
  const Settings s = bench.settings;
  for (int row = 1; row <= s.rows; ++row) {
    for (int group = 0; group < s.columns / 4; ++group) {
      while (random.chance(gaps)) {
        bench.clock(std::nullopt);
      }
      bench.clock(Beat{static_cast<std::uint32_t>(random.bits()), row == 1 && group == 0, group == s.columns / 4 - 1});
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
  }
}

// --- Tests ---

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
  for_cases(40, [&](Random& random) {
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
             static_cast<std::uint32_t>(random.between(0, (1 << 23) - 1)),
             static_cast<std::uint32_t>(random.bits())};
      }
      bench.set(s);
      bench.hold = random.chance(20) && bench.reference().taken;
      bench.idle(random.between(2, 8));
      good_frame(bench, random, random.chance(50) ? 0 : 30);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
  });
}

// Beats with tuser and tlast anywhere, gaps, and changes of settings and run_i at any time: every output equals the
// reference.
TEST(FrameTracker, BrokenInputOfEveryKind) {
  for_cases(150, [&](Random& random) {
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
  });
}

}  // namespace

}  // namespace selfproj::test::frame_tracker
