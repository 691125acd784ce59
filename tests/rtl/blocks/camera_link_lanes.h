// The LVDS lanes of a Camera Link camera: bits with skew and jitter, edges in picoseconds, sampled by a deserializer in
// the model. The PLLs are here.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_LANES_H
#define SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_LANES_H

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "tests/rtl/blocks/camera_link_bench.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

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

  // The camera's clock has stopped, or the cable was pulled, and the link starts again at this time, in another phase.
  // What it would have sent meanwhile is lost.
  void start_again(std::int64_t time) {
    for (std::int64_t lost = (time - start_) / (kBitsOfLane * bit_) - words_; lost > 0 && !queue.empty(); --lost) {
      last_frames_.push_back(queue.front().frame);
      queue.pop_front();
    }
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
    std::uint32_t word = kIdle;
    if (!queue.empty()) {
      word = link_word(queue.front().links[number_]);
      last_frames_.push_back(queue.front().frame);
      queue.pop_front();
      if (last_frames_.size() > 16) {
        last_frames_.pop_front();
      }
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      Lane& of = lanes_[static_cast<std::size_t>(lane)];
      for (int at = 0; at < kBitsOfLane; ++at) {
        const bool level = lane_bit(word, lane, at);
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

  static constexpr std::uint32_t kIdle = 1U << 26U;  // data valid alone

  Random& random_;
  std::size_t number_;
  std::int64_t bit_;
  std::int64_t start_;
  std::int64_t words_ = 0;
  std::array<Lane, kLanes> lanes_;
  std::deque<std::size_t> last_frames_;  // to which the last words belong
};

// The links with their PLLs, and the board.
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
        used_(taps <= 3   ? 1
              : taps == 4 ? 2
                          : 3),
        links_{LvdsLanes(random_, 0, bit, 100'000), LvdsLanes(random_, 1, bit, 100'000 + random_.between(0, 7 * 1500)),
               LvdsLanes(random_, 2, bit, 100'000 + random_.between(0, 7 * 1500))} {
    dut_->clk_i = 0;
    for (std::size_t number = 0; number < kLinks; ++number) {
      eclk(number) = lanes(number) = good(number) = 0;
    }
    dut_->rst_i = 1;
    until(now_ + 4 * board_);
    dut_->rst_i = 0;
    for (int number = 0; number < used_; ++number) {
      start_pll(number);
    }
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
    send({.rows = rows,
          .columns = columns,
          .max_gap = random_.chance(50) ? 1 : 6,
          .without_data = taps_ == 10 || random_.chance(50) ? 0 : 20});
  }
  void send(const LinkCamera::Shape& shape) {
    note_sent(camera_.send(shape));
    for (int number = 0; number < used_; ++number) {
      std::deque<LinkCamera::Sent>& queue = link(number).queue;
      queue.insert(queue.end(), camera_.queue().begin(), camera_.queue().end());
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
    while (sending()) {
      step();
    }
    words(60);
    until(now_ + 100 * board_);
  }

  [[nodiscard]] bool sending() const {
    return std::any_of(links_.begin(), links_.end(), [](const LvdsLanes& lanes) { return !lanes.queue.empty(); });
  }
  // Up to the next edge of the board's clock, this one included.
  void board_clock() {
    for (const std::int64_t next = next_board_; next_board_ == next;) {
      step();
    }
  }

  // The camera's clock stops, and the PLL loses its lock; both come back after this many words.
  void stop(int number, int count) {
    good(static_cast<std::size_t>(number)) = 0;
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

  [[nodiscard]] unsigned wanted() const { return (1U << static_cast<unsigned>(used_)) - 1; }

  CData& eclk(std::size_t link) { return link == 0 ? dut_->x_eclk_i : link == 1 ? dut_->y_eclk_i : dut_->z_eclk_i; }
  CData& lanes(std::size_t link) { return link == 0 ? dut_->x_lanes_i : link == 1 ? dut_->y_lanes_i : dut_->z_lanes_i; }
  CData& good(std::size_t link) { return link == 0 ? dut_->x_good_i : link == 1 ? dut_->y_good_i : dut_->z_good_i; }

  // From a moment on, edges in the middle of the bits, or a quarter of a bit before and behind it; at first the clock
  // alone, then the sign that it is good.
  void start_pll(int number) {
    const auto index = static_cast<std::size_t>(number);
    const std::int64_t first = links_[index].start() + (step_ == bit_ ? bit_ / 2 : bit_ / 4);
    next_edge_[index] = first + step_ * random_.between(20, 60);
    good_at_[index] = next_edge_[index] + 40 * bit_;
  }

  // The lanes and the clock of a link at its next edge, not yet evaluated.
  void set_edge(std::size_t number) {
    unsigned levels = 0;
    std::uint64_t random = window_ > 0 ? random_.bits() : 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      // What changes within the window of a sample is sampled old or new.
      const std::int64_t off = (static_cast<std::int64_t>(random & 0xfffU) * (2 * window_ + 1) >> 12) - window_;
      random >>= 12U;
      const std::int64_t time = std::max(sampled_[number][static_cast<std::size_t>(lane)], next_edge_[number] + off);
      sampled_[number][static_cast<std::size_t>(lane)] = time;
      levels |= static_cast<unsigned>(links_[number].level(lane, time)) << static_cast<unsigned>(lane);
    }
    // Registers take the levels at the edge, as if they had come before it.
    lanes(number) = static_cast<std::uint8_t>(levels);
    eclk(number) = eclk(number) == 0;
    next_edge_[number] += step_;
  }

  void board() {
    dut_->clk_i = 0;
    dut_.eval();
    read_outputs(dut_, !dut_->rst_i);
    dut_->clk_i = 1;
    dut_.eval();
    next_board_ += board_;
  }

  // The next edge of the board's clock, or the next edges of the links before it. What one link does reaches another
  // one only through registers of the board, so edges of different links between two of the board's may come together.
  void step() {
    now_ = std::min({next_edge_[0], next_edge_[1], next_edge_[2], next_board_});
    std::array<bool, kLinks> becomes_good{};
    bool any = false;
    for (std::size_t number = 0; number < kLinks; ++number) {
      if (next_edge_[number] == now_ || (next_edge_[number] < now_ + step_ && next_edge_[number] < next_board_)) {
        becomes_good[number] = next_edge_[number] >= good_at_[number];
        set_edge(number);
        any = true;
      }
    }
    if (any) {
      dut_.eval();
      for (std::size_t number = 0; number < kLinks; ++number) {
        if (becomes_good[number]) {
          good(number) = 1;
        }
      }
      if (watching_ && !locked()) {
        mark_broken();
      }
    }
    if (next_board_ == now_) {
      board();
    }
  }

  void mark_broken() {
    for (const LvdsLanes& lanes_of : links_) {
      for (const std::size_t frame : lanes_of.last_frames()) {
        may_break_[frame] = true;
      }
    }
  }

  Random random_;
  LinkCamera camera_;
  int taps_;
  std::int64_t step_;  // between two samples
  std::int64_t bit_;
  std::int64_t board_;
  std::int64_t window_ = 0;
  int used_;  // links
  std::array<LvdsLanes, kLinks> links_;
  Model<Dut> dut_{Begin::zeros};  // a camera's side, whose clock stands, has no reset of its own
  std::int64_t now_ = 0;
  std::int64_t next_board_ = 0;
  std::array<std::int64_t, kLinks> next_edge_{kNever, kNever, kNever};
  std::array<std::int64_t, kLinks> good_at_{};
  std::array<std::array<std::int64_t, kLanes>, kLinks> sampled_{};
  bool watching_ = false;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_LANES_H
