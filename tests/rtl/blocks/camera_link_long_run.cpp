// Tests the front end for Camera Link from its LVDS lanes on: bits with skew and jitter, edges in picoseconds, sampled
// by the ECP5's deserializer (constraints/common/ecp5_cells.sv). The PLLs are in camera_link_lanes.h, in C++.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

#include "Vecp5_camera_link_bank_eighty_ports.h"
#include "Vecp5_camera_link_bank_medium_ports.h"
#include "Vecp5_camera_link_bank_ports.h"
#include "Vecp5_camera_link_base_ports.h"
#include "Vecp5_camera_link_eighty_ports.h"
#include "Vecp5_camera_link_full_ports.h"
#include "Vecp5_camera_link_medium_ports.h"
#include "Vecp5_camera_link_twice_ports.h"
#include "tests/rtl/blocks/camera_link_lanes.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

template <>
constexpr int kDelayTaps<Vecp5_camera_link_bank_medium> = 128;

namespace {

constexpr std::int64_t kBoard = 8000;           // 125 MHz
constexpr std::int64_t kFastBoard = 4600;       // 217 MHz: 2.5 beats in a word at 85 MHz
constexpr int kShortestBit = 1681;              // 85 MHz
constexpr int kShortestBitSampledTwice = 2646;  // 54 MHz
constexpr int kLongestBit = 7142;               // 20 MHz

// Any skew, jitter and sampling window that together stay below the tolerance: every frame is whole.
template <typename Dut>
void expect_frames_within_tolerance(int taps, int samples) {
  for_cases(12, [&](Random& random, std::uint64_t seed) {
    const int bit = random.between(samples == 1 ? kShortestBit : kShortestBitSampledTwice, kLongestBit) / 4 * 4;
    LvdsBench<Dut> bench(seed, taps, samples, bit, taps > 4 ? kFastBoard : kBoard);
    bench.disturb();
    ASSERT_TRUE(bench.lock());
    for (int frame = 0; frame < 8; ++frame) {
      bench.send_any();
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_EQ(bench.overruns() + bench.apart() + bench.lost(), 0);
  });
}
TEST(CameraLinkLanes, Base) { expect_frames_within_tolerance<Vecp5_camera_link_base>(3, 1); }
TEST(CameraLinkLanes, TwoSamplesABit) { expect_frames_within_tolerance<Vecp5_camera_link_twice>(2, 2); }
TEST(CameraLinkLanes, Medium) { expect_frames_within_tolerance<Vecp5_camera_link_medium>(4, 1); }
TEST(CameraLinkLanes, Full) { expect_frames_within_tolerance<Vecp5_camera_link_full>(8, 1); }
TEST(CameraLinkLanes, Eighty) { expect_frames_within_tolerance<Vecp5_camera_link_eighty>(10, 1); }
TEST(CameraLinkBank, Medium) { expect_frames_within_tolerance<Vecp5_camera_link_bank_medium>(4, 1); }
TEST(CameraLinkBank, Full) { expect_frames_within_tolerance<Vecp5_camera_link_bank>(8, 1); }
TEST(CameraLinkBank, Eighty) { expect_frames_within_tolerance<Vecp5_camera_link_bank_eighty>(10, 1); }

// The camera's clock stops in the middle of frames and comes back in any phase.
template <typename Dut>
void expect_locks_again(int taps, int samples) {
  int broken = 0;
  for_cases(8, [&](Random& random, std::uint64_t seed) {
    // with 8 taps the board takes two beats in a word
    const int shortest = taps > 4 ? 2400 : samples == 1 ? kShortestBit : kShortestBitSampledTwice;
    const int bit = random.between(shortest, 5000) / 4 * 4;
    LvdsBench<Dut> bench(seed, taps, samples, bit, kBoard);
    ASSERT_TRUE(bench.lock());
    bench.watch_lock();
    for (int frame = 0; frame < 30; ++frame) {
      bench.send_any();
    }
    for (int round = 0; round < 3; ++round) {
      bench.words(random.between(50, 700));
      bench.stop(taps > 4 ? random.between(0, 2) : 0, random.between(1, 80));
      bench.words(10);  // until the loss is seen
      ASSERT_TRUE(bench.lock());
    }
    bench.drain();
    broken += bench.expect_frames_sent();
    EXPECT_EQ(bench.lost(), 3);
  });
  if (runs_all_cases()) {
    EXPECT_GT(broken, 8);
  }
}
TEST(CameraLinkLanes, LocksAgain) { expect_locks_again<Vecp5_camera_link_base>(3, 1); }
TEST(CameraLinkLanes, LocksAgainWithTwoSamples) { expect_locks_again<Vecp5_camera_link_twice>(2, 2); }
TEST(CameraLinkLanes, FullLocksAgain) { expect_locks_again<Vecp5_camera_link_full>(8, 1); }
TEST(CameraLinkBank, FullLocksAgain) { expect_locks_again<Vecp5_camera_link_bank>(8, 1); }

// A cable that comes, or goes and comes, while its delays are searched: its lanes are sampled off the edges afterwards.
TEST(CameraLinkBank, ACableThatComesWithinTheSearch) {
  for_cases(30, [&](Random& random, std::uint64_t seed) {
    const int bit = random.between(kShortestBit, 3000) / 4 * 4;
    LvdsBench<Vecp5_camera_link_bank> bench(seed, 8, 1, bit, kFastBoard);
    bench.disturb();
    const int link = random.between(0, 2);
    bench.words(random.between(0, 2500));
    bench.stop(link, random.between(1, 2500));
    if (random.chance(50)) {
      bench.words(random.between(0, 2500));
      bench.stop(link, random.between(2, 100));
    }
    ASSERT_TRUE(bench.lock());
    for (int frame = 0; frame < 8; ++frame) {
      bench.send_any();
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_EQ(bench.overruns() + bench.apart(), 0);
  });
}

// With two samples a bit, a data lane that is off by more than a quarter of a bit, up to three quarters: the lock ends,
// and no beat is wrong.
TEST(CameraLinkLanes, SkewBeyondTheToleranceIsNoticed) {
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    const int bit = random.between(kShortestBitSampledTwice, kLongestBit) / 4 * 4;
    LvdsBench<Vecp5_camera_link_twice> bench(seed, 2, 2, bit, kBoard);
    bench.link(0).jitter = random.between(0, bit / 40);
    ASSERT_TRUE(bench.lock());
    for (int frame = 0; frame < 2; ++frame) {
      bench.send_any();
    }
    bench.watch_lock();
    bench.words(random.between(20, 100));
    const int off = random.between(bit / 4 + bit / 40 + 1, 3 * bit / 4 - bit / 40 - 1);
    for (int frame = 0; frame < 6; ++frame) {
      bench.send_any();
    }
    const int sign = random.chance(50) ? 1 : -1;
    for (int drift = 1; drift <= 40; ++drift) {
      bench.link(0).skew[static_cast<std::size_t>(seed % 4)] = sign * off * drift / 40;
      bench.words(3);
    }
    bench.drain();
    EXPECT_GE(bench.lost(), 1);
    EXPECT_GE(bench.expect_frames_sent(), 1);
  });
}

// The PLL drifts until it samples at the edges of the clock lane: with one sample a bit, the lock ends.
TEST(CameraLinkLanes, SamplesAtTheEdgesOfTheClockEndTheLock) {
  for_cases(8, [&](std::uint64_t seed) {
    LvdsBench<Vecp5_camera_link_base> bench(seed, 3, 1, 2400, kBoard);
    bench.link(0).jitter = 200;
    ASSERT_TRUE(bench.lock());
    bench.words(50);
    EXPECT_EQ(bench.lost(), 0);
    for (int step = 0; step < 12; ++step) {
      bench.move_phase(0, 100);
      bench.words(30);
    }
    EXPECT_GE(bench.lost(), 1);
  });
}

}  // namespace
}  // namespace selfproj::test
