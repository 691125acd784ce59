// The LVDS lanes of a Camera Link camera: bits with skew and jitter, edges in picoseconds, sampled by a deserializer in
// the model. The PLLs are here, and the delays of ecp5_camera_link_bank.
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
      : random_(random), number_(static_cast<std::size_t>(number)), bit_(bit), origin_(start), start_(start) {}

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

  // The camera's clock has stopped, or the cable was pulled, and the link starts again at this time or with the next
  // word that was not sent yet, less than a word later than it would have been. What it would have sent meanwhile is
  // lost.
  void start_again(std::int64_t time) {
    constexpr auto kBits = static_cast<std::int64_t>(kBitsOfLane);
    start_ = std::max(time, origin_ + all_words_ * kBits * bit_);
    for (; all_words_ < (start_ - origin_) / (kBits * bit_); ++all_words_) {
      if (!queue.empty()) {
        last_frames_.push_back(queue.front().frame);
        queue.pop_front();
      }
    }
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
    ++all_words_;
  }

  static constexpr std::uint32_t kIdle = 1U << 26U;  // data valid alone

  Random& random_;
  std::size_t number_;
  std::int64_t bit_;
  std::int64_t origin_;
  std::int64_t start_;  // of words_, and all_words_ of origin_, with those that were lost
  std::int64_t words_ = 0;
  std::int64_t all_words_ = 0;
  std::array<Lane, kLanes> lanes_;
  std::deque<std::size_t> last_frames_;  // to which the last words belong
};

// All links are sampled by X's clock, each behind a delay (ecp5_camera_link_bank).
template <typename Dut>
concept OneBank = requires(Dut dut) {
  dut.tap_load_o;
};

// Taps of their delays, and what they delay together, as those of an ECP5.
template <typename Dut>
constexpr int kDelayTaps = 32;
inline constexpr int kMostDelay = 3200;  // ps

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
      set_lanes(number, 0);
      if (number < clocks()) {
        eclk(number) = good(number) = 0;
      }
    }
    dut_->rst_i = 1;
    until(now_ + 4 * board_);
    dut_->rst_i = 0;
    for (std::size_t number = 0; number < clocks(); ++number) {
      start_pll(number);
    }
  }

  LvdsLanes& link(int number) { return links_[static_cast<std::size_t>(number)]; }

  // Any jitter of each edge, window of each sample, and skew of the lanes, together within the tolerance.
  void disturb() {
    const auto half = static_cast<int>(step_ / 2);
    // The middle of a delay's range lies between two edges that wobble, and may be off by a tap.
    const int tolerance = OneBank<Dut> ? std::min(half, kMostDelay / 4) - kTap : half - 1;
    const int share = OneBank<Dut> ? 12 : 4;
    const int jitter = random_.between(0, tolerance / share);
    window_ = random_.between(0, tolerance / share);
    const int most = tolerance - (OneBank<Dut> ? 2 : 1) * (jitter + static_cast<int>(window_));
    for (LvdsLanes& lanes : links_) {
      lanes.jitter = jitter;
      const int all = OneBank<Dut> ? random_.between(-1000, 1000) : 0;  // the clock's, and so the link's phase
      for (std::int64_t& skew : lanes.skew) {
        skew = all + (random_.chance(30) ? (random_.chance(50) ? most : -most) : random_.between(-most, most));
      }
      if (OneBank<Dut>) {
        lanes.skew[kLanes - 1] = all;
      }
    }
  }

  // Until all links that are used are locked; false if that takes longer than 10,000 words.
  bool lock() {
    for (int words = 0; words < 10'000; ++words) {
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

  // A cable is pulled, and put back after this many words, in another phase. The PLL loses its lock; the lanes of a
  // link without a PLL stand still.
  void stop(int number, int count) {
    const auto index = static_cast<std::size_t>(number);
    const bool has_clock = index < clocks();
    out_[index] = true;
    if (has_clock) {
      good(index) = 0;
      dut_.eval();
      next_edge_[index] = kNever;
    }
    words(count);
    link(number).start_again(now_ + random_.between(0, static_cast<int>(7 * bit_)));
    out_[index] = false;
    if (has_clock) {
      start_pll(index);
    }
  }

  // The PLL's phase moves.
  void move_phase(int number, std::int64_t by) { next_edge_[static_cast<std::size_t>(number)] += by; }

  Random& random() { return random_; }
  // Frames that are under way while a link is not locked may end early.
  void watch_lock() { watching_ = true; }

 private:
  static constexpr std::int64_t kNever = INT64_MAX;

  static constexpr int kTap = kMostDelay / kDelayTaps<Dut>;  // ps

  [[nodiscard]] unsigned wanted() const { return (1U << static_cast<unsigned>(used_)) - 1; }
  [[nodiscard]] std::size_t clocks() const { return OneBank<Dut> ? 1 : static_cast<std::size_t>(used_); }

  CData& eclk(std::size_t link) {
    if constexpr (OneBank<Dut>) {
      return dut_->eclk_i;
    } else {
      return link == 0 ? dut_->x_eclk_i : link == 1 ? dut_->y_eclk_i : dut_->z_eclk_i;
    }
  }
  CData& good(std::size_t link) {
    if constexpr (OneBank<Dut>) {
      return dut_->good_i;
    } else {
      return link == 0 ? dut_->x_good_i : link == 1 ? dut_->y_good_i : dut_->z_good_i;
    }
  }
  void set_lanes(std::size_t link, unsigned levels) {
    if constexpr (OneBank<Dut>) {
      const auto at = static_cast<unsigned>(kLanes * link);
      dut_->lanes_i = static_cast<SData>((dut_->lanes_i & ~(0x1fU << at)) | levels << at);
    } else {
      (link == 0 ? dut_->x_lanes_i : link == 1 ? dut_->y_lanes_i : dut_->z_lanes_i) = static_cast<CData>(levels);
    }
  }

  // From a moment on, edges in the middle of the bits, or a quarter of a bit before and behind it; at first the clock
  // alone, then the sign that it is good.
  void start_pll(std::size_t index) {
    const std::int64_t first = links_[index].start() + (step_ == bit_ ? bit_ / 2 : bit_ / 4);
    next_edge_[index] = first + step_ * random_.between(20, 60);
    good_at_[index] = next_edge_[index] + 40 * bit_;
  }

  // The lanes of a link at an edge of its clock.
  unsigned levels_at(std::size_t number, std::int64_t edge) {
    unsigned levels = 0;
    if (out_[number]) {
      return levels;
    }
    std::uint64_t random = window_ > 0 ? random_.bits() : 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      // What changes within the window of a sample is sampled old or new.
      const std::int64_t off = (static_cast<std::int64_t>(random & 0xfffU) * (2 * window_ + 1) >> 12) - window_;
      random >>= 12U;
      const std::int64_t time = std::max(sampled_[number][static_cast<std::size_t>(lane)], edge - delay_[number] + off);
      sampled_[number][static_cast<std::size_t>(lane)] = time;
      levels |= static_cast<unsigned>(links_[number].level(lane, time)) << static_cast<unsigned>(lane);
    }
    return levels;
  }

  // The lanes and the clock of a link at its next edge, not yet evaluated; with one bank, the lanes of all links.
  void set_edge(std::size_t number) {
    // Registers take the levels at the edge, as if they had come before it.
    for (std::size_t of = number; of < (OneBank<Dut> ? static_cast<std::size_t>(used_) : number + 1); ++of) {
      set_lanes(of, levels_at(of, next_edge_[number]));
    }
    eclk(number) = eclk(number) == 0;
    next_edge_[number] += step_;
  }

  // The delays take a step at the fall of tap_move_o.
  void move_delays() {
    if constexpr (OneBank<Dut>) {
      for (std::size_t number = 0; number < kLinks; ++number) {
        if ((dut_->tap_load_o >> number & 1U) != 0) {
          delay_[number] = 0;
        } else if ((moving_ & ~dut_->tap_move_o) >> number & 1U) {
          delay_[number] += kTap;
        }
      }
      moving_ = dut_->tap_move_o;
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
      move_delays();
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
  std::array<std::int64_t, kLinks> delay_{};
  std::array<bool, kLinks> out_{};  // no cable
  unsigned moving_ = 0;
  bool watching_ = false;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_LANES_H
