// A serial image sensor, bit by bit, and the front end behind its deserializer.
//
// Every lane has a skew, a jitter and a delay with taps. The deserializer samples all lanes in the middle of the bits
// of an ideal clock (both edges of the sensor's DDR clock) and cuts them into words at a place of its own. The words
// come from two kinds of sensors: control lane with flags (CMV) or with codes (PYTHON).
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_LVDS_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_LVDS_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/rtl/blocks/camera_beats.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// How a sensor sends.
struct LvdsFormat {
  int lanes = 16;
  int bits = 10;
  bool codes = false;
  bool msb_first = false;
  int columns = 32;  // flags: of a lane
  int burst = 32;    // flags: words in a row
  int taps = 1;

  [[nodiscard]] unsigned training() const { return codes ? (bits == 8 ? 0x0E9U : 0x3A6U) : 0x055U; }
  [[nodiscard]] unsigned idle() const { return codes ? training() : 0x200U; }
  [[nodiscard]] unsigned code(unsigned of_ten_bits) const { return of_ten_bits >> static_cast<unsigned>(10 - bits); }
};

// One word of every lane.
struct LvdsWord {
  unsigned control = 0;
  std::array<unsigned, 16> data{};
  std::size_t frame = 0;  // to which it belongs, counted from 1; 0: to none
  bool at_once = false;   // it came in the clock behind that of the word before
};

constexpr int kLvdsTicks = 1000;  // of time, in a bit

// Frame start and end, line start and end, start of black pixels, black and other pixels, check word, training.
constexpr std::array<unsigned, 9> kLvdsCodes = {0x2AA, 0x32A, 0x0AA, 0x12A, 0x22A, 0x015, 0x035, 0x059, 0x3A6};

// What protects the words of a lane: their remainder, with ten bits more, divided by the polynomial of the data sheet,
// x^10 + x^9 + x^6 + x^3 + x^2 + x + 1.
template <typename WordAt>
unsigned lvds_check_word(std::size_t words, WordAt word_at) {
  unsigned rest = 0;
  const auto bring = [&rest](bool bit) {
    rest = rest << 1U | static_cast<unsigned>(bit);
    rest = (rest & 0x400U) != 0 ? rest ^ 0x64FU : rest;
  };
  for (std::size_t at = 0; at < words; ++at) {
    for (unsigned bit = 0x200U; bit != 0; bit >>= 1U) {
      bring((word_at(at) & bit) != 0);
    }
  }
  for (int i = 0; i < 10; ++i) {
    bring(false);
  }
  return rest;
}

// The pixel of a lane in a word of a line of kernels, as the figure in the data sheet has it: even kernels upwards, odd
// ones downwards, two pixels a lane one after the other.
inline std::size_t lvds_kernel_column(std::size_t lanes, std::size_t at, std::size_t lane) {
  const std::size_t kernel = at / 2;
  const std::size_t within = 2 * lane + at % 2;
  return kernel * 2 * lanes + (kernel % 2 == 0 ? within : 2 * lanes - 1 - within);
}

// Beats of pixels of `bits` bits, four in each, their upper 8 bits. `whole`: they end a line.
inline void add_lvds_beats(const std::vector<unsigned>& pixels, int bits, bool whole, Frame& frame) {
  for (std::size_t column = 0; column + 4 <= pixels.size(); column += 4) {
    Beat beat{0, frame.empty(), whole && column + 4 == pixels.size()};
    for (std::size_t i = 0; i < 4; ++i) {
      beat.pixels |= pixels[column + i] >> static_cast<unsigned>(bits - 8) << 8 * i;
    }
    frame.push_back(beat);
  }
}

// Makes the words of frames.
class LvdsFrames {
 public:
  LvdsFrames(Random& random, LvdsFormat format) : random_(random), format_(format) {}

  std::deque<LvdsWord>& queue() { return queue_; }
  [[nodiscard]] const LvdsFormat& format() const { return format_; }

  // What is sent while nothing waits.
  [[nodiscard]] LvdsWord idle() const { return word(format_.idle() | quiet_flags_, format_.training()); }
  // Flags other than the valid ones that stand in every word until they change: in gaps bits 3 to 7, in frames only the
  // two of the exposure, bits 6 and 7.
  void set_flags(unsigned flags) { quiet_flags_ = format_.codes ? 0U : flags; }

  void pause(int words) {
    for (int i = 0; i < words; ++i) {
      queue_.push_back(idle());
    }
  }

  // Queues a frame with random pixels; `kernels` of a line with codes. `gap` idle words behind it. Returns the beats.
  Frame send(int rows, int kernels, int max_gap, int gap) {
    const int columns = format_.codes ? 2 * format_.lanes * kernels : format_.lanes * format_.columns;
    Frame due;
    ++frames_;
    std::vector<unsigned> pixels(static_cast<std::size_t>(columns));
    for (int row = 0; row < rows; ++row) {
      if (format_.codes && random_.chance(row == 0 ? 50 : 10)) {
        black_line(kernels);
      }
      for (unsigned& pixel : pixels) {
        pixel = static_cast<unsigned>(random_.bits()) & ((1U << static_cast<unsigned>(format_.bits)) - 1U);
      }
      if (format_.codes) {
        line_of_kernels(pixels, row == 0, row + 1 == rows);
      } else {
        line_of_columns(pixels, row + 1 == rows, max_gap);
      }
      add_lvds_beats(pixels, format_.bits, true, due);
      if (format_.codes && row + 1 < rows) {
        pause(random_.between(0, max_gap));
      }
    }
    pause(gap);
    return due;
  }

  // The beats of a line of kernels, the only one of its frame, from its words in the queue.
  [[nodiscard]] Frame line_of(std::size_t first, std::size_t end) const {
    const auto lanes = static_cast<std::size_t>(format_.lanes);
    std::vector<unsigned> pixels((end - first) * lanes);
    for (std::size_t at = 0; at < end - first; ++at) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        pixels[lvds_kernel_column(lanes, at, lane)] = queue_[first + at].data[lane];
      }
    }
    Frame line;
    add_lvds_beats(pixels, format_.bits, true, line);
    return line;
  }

 private:
  [[nodiscard]] LvdsWord word(unsigned control, unsigned data) const {
    LvdsWord all{control, {}};
    all.data.fill(data);
    return all;
  }
  void push(unsigned control, const std::array<unsigned, 16>& data) {
    queue_.push_back({control, data, frames_, false});
  }

  // Of each lane its columns; between bursts and behind the line, words without data valid.
  void line_of_columns(const std::vector<unsigned>& pixels, bool last_line, int max_gap) {
    const unsigned rest = format_.idle() | (quiet_flags_ & 0xC0U);
    const bool holds = random_.chance(50);  // line valid stays high between the lines
    for (int at = 0; at < format_.columns; ++at) {
      std::array<unsigned, 16> data{};
      for (int lane = 0; lane < format_.lanes; ++lane) {
        data[static_cast<std::size_t>(lane)] = pixels[static_cast<std::size_t>(lane * format_.columns + at)];
      }
      push(rest | 7U, data);
      if ((at + 1) % format_.burst == 0 && !(last_line && at + 1 == format_.columns)) {
        LvdsWord between = word(rest | (holds || at + 1 < format_.columns ? 6U : 4U), format_.training());
        between.frame = frames_;
        for (int gap = random_.between(1, max_gap); gap > 0; --gap) {
          queue_.push_back(between);
        }
      }
    }
  }

  void line_of_kernels(const std::vector<unsigned>& pixels, bool first, bool last) {
    const auto lanes = static_cast<std::size_t>(format_.lanes);
    const int words = static_cast<int>(pixels.size()) / format_.lanes;
    const std::size_t begin = queue_.size();
    for (int at = 0; at < words; ++at) {
      std::array<unsigned, 16> data{};
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        data[lane] = pixels[lvds_kernel_column(lanes, static_cast<std::size_t>(at), lane)];
      }
      push(line_code(at, words, first ? 0x2AAU : 0x0AAU, last ? 0x32AU : 0x12AU, 0x035U), data);
    }
    check_word(begin);
  }

  void black_line(int kernels) {
    for (int at = 0; at < 2 * kernels; ++at) {
      std::array<unsigned, 16> data{};
      data.fill(static_cast<unsigned>(random_.bits()) & 0xFFU);
      push(line_code(at, 2 * kernels, 0x22AU, 0x12AU, 0x015U), data);
    }
    check_word(queue_.size());
    pause(3);
  }

  [[nodiscard]] unsigned line_code(int at, int words, unsigned first, unsigned last, unsigned inner) const {
    if (at == 1 || at == words - 1) {
      return 0;  // window 0
    }
    return format_.code(at == 0 ? first : at == words - 2 ? last : inner);
  }

  // Behind a line of pixels, of each lane what protects its words. (With 8 bits, anything.)
  void check_word(std::size_t first) {
    std::array<unsigned, 16> data{};
    data.fill(static_cast<unsigned>(random_.bits()) & 0xFFU);
    for (std::size_t lane = 0; format_.bits == 10 && lane < static_cast<std::size_t>(format_.lanes); ++lane) {
      data[lane] =
          lvds_check_word(queue_.size() - first, [&](std::size_t at) { return queue_[first + at].data[lane]; });
    }
    push(format_.code(0x059U), data);
  }

  Random& random_;
  LvdsFormat format_;
  std::deque<LvdsWord> queue_;
  std::size_t frames_ = 0;
  unsigned quiet_flags_ = 0;
};

// A sensor, the deserializer, the front end, and the board's side.
template <typename Dut>
class LvdsBench {
 public:
  // Periods of the sensor's words and of the board's clock.
  LvdsBench(std::uint64_t seed, LvdsFormat format, std::int64_t word_period, std::int64_t board_period)
      : random_(seed),
        frames_(random_, format),
        format_(format),
        clocks_(word_period, board_period, random_.between(0, 900)),
        place_(random_.between(0, format.bits - 1)),
        mask_((1U << static_cast<unsigned>(format.bits)) - 1U) {
    tap_ticks = 2200 / format.taps;
    name_ports(dut_);
    dut_.valid_when({"overrun_o", "cut_o", "lost_o", "damaged_o"}, [this] { return known_; });
    dut_->sensor_clk_i = 0;
    dut_->clk_i = 0;
    dut_->valid_i = 0;
    put_lanes({});
    reset();
  }

  // From now on all training is anew.
  void reset() {
    known_ = false;
    dut_->rst_i = 1;
    for (int i = 0; i < 6; ++i) {
      board_clock();
    }
    dut_->rst_i = 0;
    board_clocks(40);
    known_ = true;
    dut_.outputs_are_known();
  }

  // --- The world ---
  std::array<int, 17> skew{};  // ticks; of the control lane in the last of the lanes used
  std::array<int, 17> jitter{};
  std::array<bool, 17> dead{};
  int tap_ticks = 0;                        // of one tap; set by the constructor so that all of them are 2.2 bits
  int valid_percent = 100;                  // clocks of the sensor with a word
  bool pulled = false;                      // the cable: all lanes are low
  bool stopped = false;                     // the sensor's clock
  int damage_percent = 0;                   // words in which one bit is wrong, of the control lane or of another one
  std::vector<LvdsWord>* record = nullptr;  // of the words as they were sent

  // The deserializer cuts its words elsewhere.
  void set_place(int place) { place_ = place; }
  // A control word that is on its way is all zeros, as on a cable that is pulled.
  [[nodiscard]] bool zeros_on_their_way() const {
    bool zero = false;
    for (std::int64_t back = 0; back < 4 && back < words_; ++back) {
      zero =
          zero || ring_[static_cast<std::size_t>(format_.lanes)][static_cast<std::size_t>(words_ - back) % kRing] == 0;
    }
    return zero;
  }
  // Words that the front end keeps when it loses its lanes: a frame that has ended may not be out.
  void watch() { watching_ = true; }

  void send(int rows, int kernels, int max_gap, int gap) {
    sent_.push_back(frames_.send(rows, kernels, max_gap, gap));
    may_break_.push_back(false);
  }
  LvdsFrames& frames() { return frames_; }

  // --- Time ---
  bool aligned() { return dut_->aligned_o != 0; }
  bool wait_aligned(int words) {
    for (int i = 0; i < words && !aligned(); ++i) {
      words_in(1);
    }
    return aligned();
  }
  void words_in(int count) {
    for (const std::int64_t end = words_ + count; words_ < end;) {
      step();
    }
  }
  void board_clock() {
    while (!step().b) {
    }
  }
  void board_clocks(int count) {
    for (int i = 0; i < count; ++i) {
      board_clock();
    }
  }
  void drain() {
    while (!frames_.queue().empty()) {
      step();
    }
    words_in(2 * format_.columns + 60);
    board_clocks(200 + static_cast<int>(beats_waiting_));
  }

  // --- What came out ---
  int expect_frames_sent() { return expect_frames(beats_, sent_, may_break_); }
  std::vector<Frame>& sent() { return sent_; }
  std::vector<bool>& may_break() { return may_break_; }
  // What was sent and came; not together with watch().
  void forget() {
    sent_.clear();
    may_break_.clear();
    beats_.clear();
  }
  std::vector<Beat>& beats() { return beats_; }
  [[nodiscard]] int overruns() const { return overruns_; }
  [[nodiscard]] int cuts() const { return cuts_; }
  [[nodiscard]] int losses() const { return losses_; }
  unsigned damaged() { return dut_->damaged_o; }
  unsigned failed() { return static_cast<unsigned>(dut_->failed_o); }
  [[nodiscard]] int tap(int lane) const { return tap_[static_cast<std::size_t>(lane)]; }
  [[nodiscard]] std::int64_t words() const { return words_; }
  Random& random() { return random_; }
  void set_beats_waiting(int clocks) { beats_waiting_ = clocks; }
  Model<Dut>& dut() { return dut_; }

  // One event of the clocks; `on_board` is called with each clock of the board before its edge.
  template <typename OnBoard>
  TwoClocks::Rises step(OnBoard on_board) {
    TwoClocks::Rises rises = clocks_.next();
    rises.a = rises.a && !stopped;
    step_clocks(
        dut_, dut_->sensor_clk_i, dut_->clk_i, rises,
        [&] {
          if (rises.a) {
            const bool before = dut_->valid_i;
            dut_->valid_i = valid_percent == 100 || random_.chance(valid_percent);
            if (dut_->valid_i) {
              next_word(before);
            }
          }
        },
        [&] {
          if (rises.a) {
            move_taps();
          }
          if (rises.b && known_) {
            if (dut_->m_valid_o) {
              beats_.push_back(beat_of(dut_));
            }
            overruns_ += dut_->overrun_o;
            cuts_ += dut_->cut_o;
            losses_ += dut_->lost_o;
            on_board();
          }
        });
    return rises;
  }
  TwoClocks::Rises step() {
    return step([] {});
  }

 private:
  static constexpr std::size_t kRing = 8;

  void next_word(bool at_once) {
    ++words_;
    // The sensor is three words ahead of what is sampled.
    LvdsWord sent = frames_.idle();
    if (!frames_.queue().empty()) {
      sent = frames_.queue().front();
      frames_.queue().pop_front();
    }
    if (damage_percent != 0 && random_.chance(damage_percent)) {
      damage(sent);
    }
    if (record != nullptr) {
      record->push_back(sent);
      record->back().at_once = at_once;
    }
    for (int lane = 0; lane <= format_.lanes; ++lane) {
      const unsigned word = lane == format_.lanes ? sent.control : sent.data[static_cast<std::size_t>(lane)];
      ring_[static_cast<std::size_t>(lane)][static_cast<std::size_t>(words_) % kRing] = arrival(word);
    }
    mark_broken(sent.frame);

    std::array<unsigned, 17> raw{};
    for (int lane = 0; lane <= format_.lanes; ++lane) {
      raw[static_cast<std::size_t>(lane)] = sample(lane);
    }
    put_lanes(raw);
  }

  // One bit of the control lane or of another one. With codes, there are also two bits and other codes, and words that
  // are missing or come twice.
  void damage(LvdsWord& word) {
    if (format_.codes && random_.chance(20) && !frames_.queue().empty()) {
      if (random_.chance(50)) {
        word = frames_.queue().front();
        frames_.queue().pop_front();
      } else {
        frames_.queue().push_front(word);
      }
      return;
    }
    const int lane = random_.chance(50) ? format_.lanes : random_.between(0, format_.lanes - 1);
    unsigned& hit = lane == format_.lanes ? word.control : word.data[static_cast<std::size_t>(lane)];
    if (format_.codes && lane == format_.lanes && random_.chance(30)) {
      hit = random_.chance(30) ? static_cast<unsigned>(random_.between(0, 15)) << (format_.bits == 8 ? 2U : 0U)
                               : format_.code(kLvdsCodes.at(static_cast<std::size_t>(random_.between(0, 8))));
      return;
    }
    for (int bits = format_.codes && random_.chance(50) ? 2 : 1; bits > 0; --bits) {
      hit ^= 1U << static_cast<unsigned>(random_.between(0, format_.bits - 1));
    }
  }

  // The word in the order of arrival, the first bit in bit 0.
  [[nodiscard]] unsigned arrival(unsigned word) const {
    if (!format_.msb_first) {
      return word;
    }
    unsigned turned = 0;
    for (int i = 0; i < format_.bits; ++i) {
      turned |= (word >> static_cast<unsigned>(i) & 1U) << static_cast<unsigned>(format_.bits - 1 - i);
    }
    return turned;
  }

  // The words of a lane that were sent three words ago and around it, one behind the other.
  [[nodiscard]] std::uint64_t stream(std::size_t lane) const {
    std::uint64_t bits = 0;
    for (std::int64_t back = 0; back < 5; ++back) {  // the oldest in the lowest bits
      const auto at = static_cast<std::size_t>(words_ - back) % kRing;
      bits = bits << static_cast<unsigned>(format_.bits) | ring_[lane][at];
    }
    return bits;
  }

  unsigned sample(int number) {
    const auto lane = static_cast<std::size_t>(number);
    if (pulled || dead[lane] || words_ < 6) {
      return 0;
    }
    const std::uint64_t bits = stream(lane);
    // Where the first sample of the word lies: in the middle of a bit of an ideal lane
    const int base = (2 * format_.bits + place_) * kLvdsTicks + kLvdsTicks / 2 - skew[lane] - tap_[lane] * tap_ticks;
    const int within = base % kLvdsTicks;
    const int wobble = jitter[lane];
    if (within >= wobble && within < kLvdsTicks - wobble) {
      return static_cast<unsigned>(bits >> static_cast<unsigned>(base / kLvdsTicks)) & mask_;
    }
    unsigned word = 0;
    for (int i = 0; i < format_.bits; ++i) {
      const int time = base + i * kLvdsTicks + random_.between(-wobble, wobble);
      word |= static_cast<unsigned>(bits >> static_cast<unsigned>(time / kLvdsTicks) & 1U) << static_cast<unsigned>(i);
    }
    return word;
  }

  void put_lanes(const std::array<unsigned, 17>& raw) {
    auto& port = dut_->lanes_i;
    if constexpr (std::is_integral_v<std::remove_reference_t<decltype(port)>>) {
      std::uint64_t all = 0;
      for (int lane = 0; lane <= format_.lanes; ++lane) {
        all |= std::uint64_t{raw[static_cast<std::size_t>(lane)]} << static_cast<unsigned>(format_.bits * lane);
      }
      port = static_cast<std::remove_reference_t<decltype(port)>>(all);
    } else {
      std::array<std::uint32_t, 8> all{};
      for (int lane = 0; lane <= format_.lanes; ++lane) {
        const auto at = static_cast<unsigned>(format_.bits * lane);
        const std::uint64_t word = std::uint64_t{raw[static_cast<std::size_t>(lane)]} << at % 32U;
        all[at / 32U] |= static_cast<std::uint32_t>(word);
        all[at / 32U + 1] |= static_cast<std::uint32_t>(word >> 32U);
      }
      const int used = ((format_.lanes + 1) * format_.bits + 31) / 32;
      for (int i = 0; i < used; ++i) {
        port[static_cast<std::size_t>(i)] = all[static_cast<std::size_t>(i)];
      }
    }
  }

  // The delays move with the pulses' rises. A pulse is high for four clocks, after it was low for four or more, and the
  // direction stands from four clocks before it until after it.
  void move_taps() {
    const auto load = static_cast<unsigned>(dut_->tap_load_o);
    const auto move = static_cast<unsigned>(dut_->tap_move_o);
    const bool up = dut_->tap_up_o != 0;
    up_stood_ = up == last_up_ ? up_stood_ + 1 : 1;
    for (int lane = 0; lane <= format_.lanes; ++lane) {
      int& tap = tap_[static_cast<std::size_t>(lane)];
      int& stood = pulse_stood_[static_cast<std::size_t>(lane)];
      const unsigned bit = 1U << static_cast<unsigned>(lane);
      const bool was = ((last_load_ | last_move_) & bit) != 0;
      const bool is = ((load | move) & bit) != 0;
      if ((load & ~last_load_ & bit) != 0) {
        tap = 0;
      } else if ((move & ~last_move_ & bit) != 0) {
        tap += up ? 1 : -1;
        EXPECT_GE(tap, 0);
        EXPECT_LT(tap, format_.taps);
      }
      if (known_ && is && !was) {
        EXPECT_GE(stood, 4) << "a pulse too soon";
        EXPECT_GE(up_stood_, 5) << "the direction has just changed";
      }
      if (known_ && was && !is) {
        EXPECT_EQ(stood, 4) << "clocks of a pulse";
        EXPECT_GE(up_stood_, 5) << "the direction changes within a pulse";
      }
      stood = is == was ? stood + 1 : 1;
    }
    last_load_ = load;
    last_move_ = move;
    last_up_ = up;
  }

  // While a lane is not aligned, the frames of the last words may end early.
  void mark_broken(std::size_t frame) {
    recent_.push_back(frame);
    if (recent_.size() > static_cast<std::size_t>(2 * format_.columns + 40)) {
      recent_.pop_front();
    }
    if (watching_ && known_ && (pulled || !aligned())) {
      for (const std::size_t one : recent_) {
        if (one != 0) {
          may_break_[one - 1] = true;
        }
      }
    }
  }

  Random random_;
  LvdsFrames frames_;
  LvdsFormat format_;
  TwoClocks clocks_;
  int place_;
  unsigned mask_;
  Model<Dut> dut_{Begin::zeros};  // a sensor's side, whose clock stands, has no reset of its own
  std::array<std::array<unsigned, kRing>, 17> ring_{};
  std::array<int, 17> tap_{};
  unsigned last_load_ = 0;
  unsigned last_move_ = 0;
  bool last_up_ = false;
  std::array<int, 17> pulse_stood_{};  // clocks since a lane's pulse began or ended
  int up_stood_ = 0;                   // clocks since the direction changed
  std::int64_t words_ = 0;
  std::deque<std::size_t> recent_;
  std::vector<Frame> sent_;
  std::vector<bool> may_break_;
  std::vector<Beat> beats_;
  int overruns_ = 0;
  int cuts_ = 0;
  int losses_ = 0;
  std::int64_t beats_waiting_ = 0;
  bool watching_ = false;
  bool known_ = false;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_LVDS_BENCH_H
