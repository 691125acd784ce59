// Compares the trigger sequencer with the times that its header states.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "Vsp_trigger_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

struct TriggerSettings {
  int last_pattern = 0;
  int period = 1;
  int camera = 0;
  int width = 1;
};

// The expected outputs in each clock of one run of pulses. run_i is high in the clocks 0..clocks - 1, and low
// afterwards.
struct Expected {
  std::vector<int> projector;
  std::vector<int> camera;
  std::vector<int> pattern;  // from the first camera pulse on; -1 before
};

Expected expected_outputs(const TriggerSettings& s, int clocks, int after) {
  const int all = clocks + after;
  const auto total = static_cast<std::size_t>(all);
  Expected out = {std::vector<int>(total), std::vector<int>(total), std::vector<int>(total, -1)};
  const auto pulse = [&](std::vector<int>& line, int first) {
    // two clocks after run_i has fallen every pulse is over
    for (int t = first; t < first + s.width && t < clocks + 2; ++t) {
      line[static_cast<std::size_t>(t)] = 1;
    }
  };
  for (int k = 0; k * s.period < clocks; ++k) {
    const int begin = k * s.period;
    pulse(out.projector, begin + 4);
    if (s.camera < s.period) {
      const int first = begin + s.camera + 4;
      pulse(out.camera, first);
      // the index is valid when the camera pulse begins, even if the pulse is cut short immediately
      if (first < clocks + 2) {
        for (auto t = static_cast<std::size_t>(first); t < total; ++t) {
          out.pattern[t] = k % (s.last_pattern + 1);
        }
      }
    }
  }
  return out;
}

class TriggerBench {
 public:
  TriggerBench() {
    trigger_->run_i = 0;
    trigger_->on_frame_i = 0;
    trigger_->captured_i = 0;
    trigger_->set_i = 0;
    trigger_->last_pattern_i = 0;
    trigger_->period_i = 0;
    trigger_->camera_i = 0;
    trigger_->width_i = 0;
    trigger_.reset();
    set({});
    trigger_.tick();  // the outputs follow their counters one clock later
  }

  // One clock that announces new settings, and one with them.
  void set(const TriggerSettings& s) {
    trigger_->set_i = 1;
    trigger_.tick();
    trigger_->set_i = 0;
    trigger_->last_pattern_i = static_cast<CData>(s.last_pattern);
    trigger_->period_i = static_cast<IData>(s.period);
    trigger_->camera_i = static_cast<IData>(s.camera);
    trigger_->width_i = static_cast<SData>(s.width);
    trigger_.settle();
    trigger_.rise();
  }

  // Sets run_i for `clocks` clocks. Frames come at random and must have no effect.
  void run(const TriggerSettings& s, int clocks, Random& random) {
    set(s);
    constexpr int kAfter = 6;
    const Expected expected = expected_outputs(s, clocks, kAfter);
    const int pattern_before = trigger_->pattern_o;
    for (int t = 0; t < clocks + kAfter; ++t) {
      const auto i = static_cast<std::size_t>(t);
      trigger_->run_i = t < clocks;
      trigger_->captured_i = t < clocks && random.chance(20);
      trigger_.settle();
      ASSERT_EQ(trigger_->projector_o, expected.projector[i]) << "clock " << t;
      ASSERT_EQ(trigger_->camera_o, expected.camera[i]) << "clock " << t;
      const int held = expected.pattern[i] < 0 ? pattern_before : expected.pattern[i];
      // with run_i low the index is 0 two clocks later
      ASSERT_EQ(trigger_->pattern_o, t < clocks + 2 ? held : 0) << "clock " << t;
      trigger_.rise();
    }
    trigger_->captured_i = 0;
  }

  Clocked<Vsp_trigger>& trigger() { return trigger_; }

 private:
  Clocked<Vsp_trigger> trigger_;
};

TEST(Trigger, EdgesOfTheSettings) {
  Random random(1);
  const std::vector<TriggerSettings> table = {
      {0, 1, 0, 1},                     // a pulse every clock: the lines stay high
      {3, 1, 0, 0},                     // no pulse at all
      {3, 2, 0, 1},                     // every second clock
      {3, 2, 1, 1},                     // the latest camera pulse
      {3, 10, 9, 3},                    // likewise
      {3, 10, 10, 3},                   // a camera delay of one period: no camera pulse
      {3, 10, 11, 3},                   // later: none
      {0, 7, 2, 2},                     // one pattern only
      {255, 3, 1, 1},                   // all patterns, with a wrap
      {11, 20, 5, 20},                  // a pulse as long as the period
      {11, 20, 5, 50},                  // longer
      {2, 0xFFFFFF, 0xAAAAAA, 0xAAAA},  // long past the end of this run, except for the first pulse
      {2, 0x555555, 0x555554, 0x5555},
      {1, 300, 260, 258},        // more than 8 bits
      {5, 0x101, 0x100, 0x100},  // values that share their low bits with the special values 0, 1 and 2
      {5, 0x102, 0x101, 0x200},
      {5, 0x202, 0x102, 0x101},
      {5, 0x1'0001, 0x1'0000, 0x1000},
      {5, 0x80'0002, 0x80'0001, 0x8000},
      {5, 0x10'0001, 0x8'0002, 0x4000},
  };
  for (const TriggerSettings& s : table) {
    SCOPED_TRACE(::testing::Message() << "last " << s.last_pattern << " period " << s.period << " camera " << s.camera
                                      << " width " << s.width);
    TriggerBench bench;
    bench.run(s, 900, random);
    ASSERT_FALSE(::testing::Test::HasFatalFailure());
  }
}

TEST(Trigger, RandomSettingsAndRuns) {
  for_cases(60, [&](Random& random) {
    TriggerBench bench;
    for (int run = 0; run < 8; ++run) {
      const int period = random.between(1, 40);
      bench.run({random.between(0, 5), period, random.between(0, period + 2), random.between(0, 50)},
                random.between(1, 400), random);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
  });
}

// Every counter has its full width: pulses of 2^16 - 1 clocks, and every bit of the settings once set and once clear.
TEST(Trigger, LongPulses) {
  Random random(1);
  for (const TriggerSettings& s : std::vector<TriggerSettings>{{1, 70001, 69000, 65535},
                                                               {255, 0x1'5555, 0xAAAA, 0xAAAA},
                                                               {255, 0x1'AAAA, 0x1'5555, 0x5555},
                                                               {7, 0x1'0FFF, 0x1'0000, 0x1000}}) {
    TriggerBench bench;
    bench.run(s, 200000, random);
    ASSERT_FALSE(::testing::Test::HasFatalFailure());
  }
}

// The longest period.
TEST(Trigger, LongestPeriod) {
  constexpr int kPeriod = 0xFF'FFFF;
  constexpr int kCamera = 0xAA'AAAA;
  TriggerBench bench;
  bench.set({.last_pattern = 1, .period = kPeriod, .camera = kCamera, .width = 1});
  auto& trigger = bench.trigger();
  trigger->run_i = 1;
  const std::int64_t begin = trigger.clock();
  std::vector<std::int64_t> projector;
  std::vector<std::int64_t> camera;
  while (trigger.clock() < begin + kPeriod + 10) {
    trigger.settle();
    if (trigger->projector_o != 0) {
      projector.push_back(trigger.clock() - begin);
    }
    if (trigger->camera_o != 0) {
      camera.push_back(trigger.clock() - begin);
    }
    trigger.rise();
  }
  EXPECT_EQ(projector, (std::vector<std::int64_t>{4, kPeriod + 4}));
  EXPECT_EQ(camera, (std::vector<std::int64_t>{kCamera + 4}));
}

// Without pulses each frame start advances the index. The first frame has index 0.
TEST(Trigger, OnFrameTheIndexAdvancesWithEachFrame) {
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    TriggerBench bench;
    auto& trigger = bench.trigger();
    // one of the eight bits, all but one, all, or a few of the lower ones
    const int bit = 1 << (seed % 8);
    const int last = seed <= 8 ? bit : seed <= 16 ? 255 - bit : seed == 17 ? 255 : random.between(0, 12);
    bench.set({last, 5, 1, 2});
    int index = 0;
    std::array<bool, 4> was_on{};  // one clock ago, two, three, four
    bool captured = false;         // a clock ago
    for (int t = 0; t < 1200; ++t) {
      const bool on = t % 700 < 650 && t % 350 != 300;  // sometimes off, even for one clock: the index goes back to 0
      trigger->on_frame_i = on;
      trigger->captured_i = random.chance(60);
      trigger.settle();
      ASSERT_EQ(trigger->pattern_o, index) << "clock " << t;
      ASSERT_EQ(trigger->projector_o, 0);
      ASSERT_EQ(trigger->camera_o, 0);
      // frames count three clocks after on_frame_i, and the index goes back in the second clock after that has fallen
      if (!was_on[0] || !was_on[1] || !was_on[2]) {
        index = 0;
      } else if (was_on[3] && captured) {
        index = index == last ? 0 : index + 1;
      }
      was_on = {on, was_on[0], was_on[1], was_on[2]};
      captured = trigger->captured_i != 0;
      trigger.rise();
    }
  });
}

// Switches from pulses to frames and back, even for one clock. Each begins with index 0, regardless of the history.
TEST(Trigger, TheIndexBeginsAnewWhereRunChanges) {
  for_cases(20, [&](Random& random) {
    TriggerBench bench;
    auto& trigger = bench.trigger();
    for (int turn = 0; turn < 12; ++turn) {
      const bool run = turn % 2 == 0;
      const TriggerSettings s = {random.between(0, 3), random.between(1, 6), 0, random.between(0, 3)};
      if (run) {  // while frames are counted
        bench.set({trigger->last_pattern_i, s.period, 0, s.width});
      }
      trigger->last_pattern_i = static_cast<CData>(s.last_pattern);  // with run_i
      trigger->run_i = run ? 1 : 0;
      trigger->on_frame_i = 1;
      const int clocks = random.chance(20) ? 1 : random.between(4, 60);
      int index = 0;
      bool captured = false;  // a clock ago
      for (int t = 0; t < clocks; ++t) {
        trigger->captured_i = random.chance(50);
        trigger.settle();
        if (run && t >= 4) {  // the first camera pulse begins with clock 4
          ASSERT_EQ(trigger->pattern_o, (t - 4) / s.period % (s.last_pattern + 1)) << "clock " << t;
        } else if (!run && t >= 4) {
          ASSERT_EQ(trigger->pattern_o, index) << "clock " << t;
          index = !captured ? index : index == s.last_pattern ? 0 : index + 1;
        }
        captured = trigger->captured_i != 0;
        if (!run && t >= 2) {
          ASSERT_EQ(trigger->projector_o, 0);
          ASSERT_EQ(trigger->camera_o, 0);
        }
        trigger.rise();
      }
    }
  });
}

// A camera that misses a pulse does not shift the indices: pattern_o follows the pulses, not the frames.
TEST(Trigger, FramesDoNotMoveTheIndexWhilePulsesRun) {
  TriggerBench with_frames;
  TriggerBench without;
  Random random(1);
  for (TriggerBench* bench : {&with_frames, &without}) {
    bench->set({4, 9, 3, 2});
    bench->trigger()->run_i = 1;
    bench->trigger()->on_frame_i = 1;
  }
  for (int t = 0; t < 300; ++t) {
    with_frames.trigger()->captured_i = random.chance(30);
    with_frames.trigger().tick();
    without.trigger().tick();
    ASSERT_EQ(with_frames.trigger()->pattern_o, without.trigger()->pattern_o);
  }
}

}  // namespace
}  // namespace selfproj::test
