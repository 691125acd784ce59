// Tests the front end for Camera Link from its LVDS lanes on: bits with skew and jitter, edges in picoseconds, sampled
// by the ECP5's deserializer (constraints/common/ecp5_cells.sv). The PLLs are here, in C++.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "Vecp5_camera_link_base_ports.h"
#include "Vecp5_camera_link_medium_ports.h"
#include "Vecp5_camera_link_twice_ports.h"
#include "tests/rtl/blocks/camera_beats.h"
#include "tests/rtl/blocks/camera_link_bench.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The lanes of one Channel Link with its transmitter. Times in ps.
class LvdsLanes {
 public:
  LvdsLanes(Random& random, int number, std::int64_t bit, std::int64_t start)
      : random_(random), number_(static_cast<std::size_t>(number)), bit_(bit), start_(start) {}

  std::array<std::int64_t, kLanes> skew{};
  std::int64_t jitter = 0;  // each edge comes at most this much early or late
  std::deque<LinkCamera::Sent> queue;

  // The level of a lane; times must not fall.
  bool level(int lane, std::int64_t time) {
    while (start_ + words_ * kBitsOfLane * bit_ < time + 2 * kBitsOfLane * bit_) {
      send_word();
    }
    Lane& of = lanes_[static_cast<std::size_t>(lane)];
    while (!of.edges.empty() && of.edges.front() <= time) {
      of.level = !of.level;
      of.edges.pop_front();
    }
    return of.level;
  }

  // The camera's clock has stopped, and starts again at this time, in another phase.
  void start_again(std::int64_t time) {
    start_ = time;
    words_ = 0;
    for (Lane& lane : lanes_) {
      lane.edges.clear();
      lane.sent = lane.level;
    }
  }

  [[nodiscard]] std::int64_t start() const { return start_; }
  [[nodiscard]] const std::deque<std::size_t>& last_frames() const { return last_frames_; }

 private:
  struct Lane {
    bool level = false;  // at the receiver
    bool sent = false;   // after the last edge
    std::deque<std::int64_t> edges;
  };

  void send_word() {
    LinkPins pins{.data = true};
    if (!queue.empty()) {
      pins = queue.front().links[number_];
      last_frames_.push_back(queue.front().frame);
      queue.pop_front();
      if (last_frames_.size() > 16) {
        last_frames_.pop_front();
      }
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      Lane& of = lanes_[static_cast<std::size_t>(lane)];
      for (int at = 0; at < kBitsOfLane; ++at) {
        const bool level = lane_bit(pins, lane, at);
        if (level != of.sent) {
          const auto wobble = random_.between(-static_cast<int>(jitter), static_cast<int>(jitter));
          of.edges.push_back(start_ + (words_ * kBitsOfLane + at) * bit_ + skew[static_cast<std::size_t>(lane)] +
                             wobble);
          of.sent = level;
        }
      }
    }
    ++words_;
  }

  Random& random_;
  std::size_t number_;
  std::int64_t bit_;
  std::int64_t start_;
  std::int64_t words_ = 0;
  std::array<Lane, kLanes> lanes_;
  std::deque<std::size_t> last_frames_;  // to which the last words belong
};

// Two links with their PLLs, and the board.
template <typename Dut>
class LvdsBench : public LinkOutputs {
 public:
  LvdsBench(std::uint64_t seed, int taps, int samples, std::int64_t bit, std::int64_t board)
      : random_(seed),
        camera_(random_, taps, 8),
        taps_(taps),
        step_(bit / samples),
        bit_(bit),
        board_(board),
        links_{LvdsLanes(random_, 0, bit, 100'000),
               LvdsLanes(random_, 1, bit, 100'000 + random_.between(0, 7 * 1500))} {
    dut_->x_eclk_i = dut_->y_eclk_i = dut_->clk_i = 0;
    dut_->x_lanes_i = dut_->y_lanes_i = 0;
    dut_->x_good_i = dut_->y_good_i = 0;
    dut_->rst_i = 1;
    until(now_ + 4 * board_);
    dut_->rst_i = 0;
    start_pll(0);
    start_pll(1);
  }

  LvdsLanes& link(int number) { return links_[static_cast<std::size_t>(number)]; }

  // Until all links that are used are locked; false if that takes longer than 5,000 words.
  bool lock() {
    for (int words = 0; words < 5000; ++words) {
      if (locked()) {
        return true;
      }
      until(now_ + kBitsOfLane * bit_);
    }
    return false;
  }
  bool locked() { return (dut_->locked_o & wanted()) == wanted(); }

  void send(int rows, int columns) {
    note_sent(camera_.send({.rows = rows,
                            .columns = columns,
                            .max_gap = random_.chance(50) ? 1 : 6,
                            .without_data = random_.chance(50) ? 0 : 20}));
    for (LvdsLanes& lanes : links_) {
      lanes.queue.insert(lanes.queue.end(), camera_.queue().begin(), camera_.queue().end());
    }
    camera_.queue().clear();
  }
  void send_any() { send(random_.between(1, 5), taps_ * random_.between(20, 40)); }

  void until(std::int64_t time) {
    while (now_ < time) {
      step();
    }
  }
  void words(int count) { until(now_ + count * kBitsOfLane * bit_); }
  void drain() {
    while (!links_[0].queue.empty() || !links_[1].queue.empty()) {
      step();
    }
    words(60);
    until(now_ + 100 * board_);
  }

  // The camera's clock stops, and the PLL loses its lock; both come back after this many words.
  void stop(int number, int count) {
    (number == 0 ? dut_->x_good_i : dut_->y_good_i) = 0;
    dut_.eval();
    next_edge_[static_cast<std::size_t>(number)] = kNever;
    words(count);
    link(number).start_again(now_ + random_.between(0, static_cast<int>(7 * bit_)));
    start_pll(number);
  }

  // The PLL's phase moves.
  void move_phase(int number, std::int64_t by) { next_edge_[static_cast<std::size_t>(number)] += by; }
  void set_window(std::int64_t window) { window_ = window; }

  Random& random() { return random_; }
  // Frames that are under way while a link is not locked may end early.
  void watch_lock() { watching_ = true; }

 private:
  static constexpr std::int64_t kNever = INT64_MAX;

  [[nodiscard]] unsigned wanted() const { return taps_ == 4 ? 3U : 1U; }

  // From a moment on, edges in the middle of the bits, or a quarter of a bit before and behind it; at first the clock
  // alone, then the sign that it is good.
  void start_pll(int number) {
    const auto index = static_cast<std::size_t>(number);
    const std::int64_t first = links_[index].start() + (step_ == bit_ ? bit_ / 2 : bit_ / 4);
    next_edge_[index] = first + step_ * random_.between(20, 60);
    good_at_[index] = next_edge_[index] + 40 * bit_;
  }

  void edge(std::size_t number) {
    unsigned lanes = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      // What changes within the window of a sample is sampled old or new.
      const auto off = random_.between(-static_cast<int>(window_), static_cast<int>(window_));
      const std::int64_t time = std::max(sampled_[number][static_cast<std::size_t>(lane)], next_edge_[number] + off);
      sampled_[number][static_cast<std::size_t>(lane)] = time;
      lanes |= static_cast<unsigned>(links_[number].level(lane, time)) << static_cast<unsigned>(lane);
    }
    (number == 0 ? dut_->x_lanes_i : dut_->y_lanes_i) = static_cast<std::uint8_t>(lanes);
    dut_.eval();
    if (number == 0) {
      dut_->x_eclk_i = dut_->x_eclk_i == 0;
    } else {
      dut_->y_eclk_i = dut_->y_eclk_i == 0;
    }
    dut_.eval();
    next_edge_[number] += step_;
    if (watching_ && !locked()) {
      for (const LvdsLanes& lanes_of : links_) {
        for (const std::size_t frame : lanes_of.last_frames()) {
          may_break_[frame] = true;
        }
      }
    }
  }

  void board() {
    dut_->clk_i = 0;
    dut_.eval();
    read_outputs(dut_, !dut_->rst_i);
    dut_->clk_i = 1;
    dut_.eval();
    next_board_ += board_;
  }

  void step() {
    now_ = std::min({next_edge_[0], next_edge_[1], next_board_});
    for (std::size_t number = 0; number < 2; ++number) {
      if (next_edge_[number] == now_) {
        edge(number);
        if (now_ >= good_at_[number]) {
          (number == 0 ? dut_->x_good_i : dut_->y_good_i) = 1;
        }
      }
    }
    if (next_board_ == now_) {
      board();
    }
  }

  Random random_;
  LinkCamera camera_;
  int taps_;
  std::int64_t step_;  // between two samples
  std::int64_t bit_;
  std::int64_t board_;
  std::int64_t window_ = 0;
  std::array<LvdsLanes, 2> links_;
  Model<Dut> dut_{Begin::zeros};  // a camera's side, whose clock stands, has no reset of its own
  std::int64_t now_ = 0;
  std::int64_t next_board_ = 0;
  std::array<std::int64_t, 2> next_edge_{kNever, kNever};
  std::array<std::int64_t, 2> good_at_{};
  std::array<std::array<std::int64_t, kLanes>, 2> sampled_{};
  bool watching_ = false;
};

constexpr std::int64_t kBoard = 8000;           // 125 MHz
constexpr int kShortestBit = 1681;              // 85 MHz
constexpr int kShortestBitSampledTwice = 2646;  // 54 MHz
constexpr int kLongestBit = 7142;               // 20 MHz

// Any skew, jitter and sampling window that together stay below the tolerance: every frame is whole.
template <typename Dut>
void expect_frames_within_tolerance(int taps, int samples) {
  for_cases(12, [&](Random& random, std::uint64_t seed) {
    const int bit = random.between(samples == 1 ? kShortestBit : kShortestBitSampledTwice, kLongestBit) / 4 * 4;
    LvdsBench<Dut> bench(seed, taps, samples, bit, kBoard);
    const int tolerance = bit / (2 * samples) - 1;
    const int window = random.between(0, tolerance / 4);
    const int jitter = random.between(0, tolerance / 4);
    for (int number = 0; number < 2; ++number) {
      bench.link(number).jitter = jitter;
      for (std::int64_t& skew : bench.link(number).skew) {
        const int most = tolerance - window - jitter;
        skew = random.chance(30) ? (random.chance(50) ? most : -most) : random.between(-most, most);
      }
    }
    bench.set_window(window);
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

// The camera's clock stops in the middle of frames and comes back in any phase.
template <typename Dut>
void expect_locks_again(int taps, int samples) {
  int broken = 0;
  for_cases(8, [&](Random& random, std::uint64_t seed) {
    const int bit = random.between(samples == 1 ? kShortestBit : kShortestBitSampledTwice, 5000) / 4 * 4;
    LvdsBench<Dut> bench(seed, taps, samples, bit, kBoard);
    ASSERT_TRUE(bench.lock());
    bench.watch_lock();
    for (int frame = 0; frame < 30; ++frame) {
      bench.send_any();
    }
    for (int round = 0; round < 3; ++round) {
      bench.words(random.between(50, 700));
      bench.stop(0, random.between(1, 80));
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
