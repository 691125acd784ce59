// Sends frames into the Gray-code decoder with any memory, and compares every output with the model clock by clock.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_GRAY_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_GRAY_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/little_endian.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/code_beats.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// Gives the pattern index as sp_frame_info does: some clocks after the start of a frame, when the next frame may
class PatternIndex {
 public:
  static constexpr int kDelay = 4;  // clocks from a frame's start to its index

  // A frame with this pattern starts in this clock. Call in the order of the clocks.
  void start(std::int64_t clock, int pattern) { coming_.emplace_back(clock + kDelay, pattern); }

  // Sets pattern_i if an index comes in this clock. Call in every clock.
  template <typename Dut>
  void drive(Dut& dut, std::int64_t clock) {
    if (!coming_.empty() && coming_.front().first == clock) {
      dut.pattern_i = static_cast<std::uint16_t>(coming_.front().second);
      coming_.pop_front();
    }
  }

 private:
  std::deque<std::pair<std::int64_t, int>> coming_;  // clock, pattern
};

// A beat of sp_frame_tracker.
struct GrayBeat {
  std::array<std::uint8_t, 4> pixels{};
  bool start = false;
  bool line_start = false;
  bool line_end = false;
  bool last_row = false;
};

template <typename Dut>
class GrayBench {
 public:
  static constexpr int kLatency = 7;  // from a beat to its codes
  static constexpr int kTooClose = 6;
  static constexpr int kTakeDistance = 7;

  // The memory behind the decoder, if the bench plays its part.
  static constexpr bool kOwnMemory = requires(Dut & dut) { dut.mem_read_o; };

  explicit GrayBench(Random& random) : random_(random), model_({.rows = 1, .columns = 4, .bits = 1}) {
    dut_.valid_when({"codes_o", "codes_start_o", "codes_line_start_o", "codes_line_end_o"},
                    [this] { return dut_->codes_valid_o != 0; });
    dut_.valid_when({"codes_status_o"}, [this] { return dut_->codes_break_o != 0; });
    if constexpr (kOwnMemory) {
      dut_.valid_when({"codes_last_row_o"}, [this] { return dut_->codes_valid_o != 0; });
      dut_.valid_when({"mem_read_first_o"}, [this] { return dut_->mem_read_o != 0; });
      dut_.valid_when({"mem_write_first_o"}, [this] { return dut_->mem_write_o != 0; });
      dut_.valid_when({"mem_data_o"}, [this] { return dut_->mem_write_o != 0; });
      dut_->mem_late_i = 0;
    }
    dut_->take_i = 0;
    dut_->beat_valid_i = 0;
    dut_->frame_start_i = 0;
    dut_->break_i = 0;
    dut_.reset();
  }

  Clocked<Dut>& dut() { return dut_; }
  [[nodiscard]] std::uint64_t pixels() const { return codes_.pixels; }  // whose codes were compared
  [[nodiscard]] std::uint64_t abandoned() const { return abandoned_; }
  [[nodiscard]] std::uint64_t late() const { return late_; }

  // The settings that the next take-over will apply.
  model::GraySettings settings;
  bool decode = true;
  int busy_percent = 0;   // share of frames for whose codes the median has no room, if the bench plays the median
  int late_permille = 0;  // share of words that come too late, if the bench plays the memory

  // Whether a frame that starts in this clock may take over settings.
  [[nodiscard]] bool may_take() { return dut_.clock() >= next_take_; }

  // One clock, with or without a beat of a frame with `pattern`, and with a break of the previous frame if a status is
  // given.
  void clock(const std::optional<GrayBeat>& beat, int pattern, std::uint32_t break_status) {
    const std::int64_t now = dut_.clock();
    Dut& dut = dut_.dut();
    dut.break_i = break_status != 0;
    dut.break_status_i = static_cast<CData>(break_status != 0 ? break_status : random_.bits() & 31U);
    if (break_status != 0) {
      model_.end(false);
      open_ = false;
      breaks(now + kLatency, break_status);
      ends_.push_back(now + kLatency);
    }
    dut.take_i = 0;
    dut.beat_valid_i = beat.has_value();
    dut.frame_start_i = beat && beat->start;
    patterns_.drive(dut, now);
    if (beat) {
      drive(*beat, pattern, now);
    } else {  // no output may depend on these
      dut.beat_pixels_i = static_cast<IData>(random_.bits());
      dut.beat_line_start_i = random_.bits() & 1U;
      dut.beat_line_end_i = random_.bits() & 1U;
      dut.beat_last_row_i = random_.bits() & 1U;
    }
    if constexpr (kOwnMemory) {
      dut.busy_i = random_.chance(50);  // counts only four clocks after a frame's start
      if (!busy_.empty() && busy_.front().clock == now) {
        dut.busy_i = busy_.front().late;
        busy_.pop_front();
      }
    }
    answer_reads(now);
    dut_.settle();
    check(now);
    if constexpr (kOwnMemory) {
      write_memory();
    }
    dut_.rise();
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks && !::testing::Test::HasFatalFailure(); ++i) {
      clock(std::nullopt, 0, 0);
    }
  }

 private:
  struct Answer {
    std::int64_t clock;
    bool late;
  };

  // Ports whose width depends on the build.
  template <typename Port>
  static void set(Port& port, int value) {
    port = static_cast<Port>(value);
  }

  void drive(const GrayBeat& beat, int pattern, std::int64_t now) {
    Dut& dut = dut_.dut();
    dut.beat_pixels_i = model::load_little_endian<std::uint32_t>(beat.pixels.data());
    dut.beat_line_start_i = beat.line_start;
    dut.beat_line_end_i = beat.line_end;
    dut.beat_last_row_i = beat.last_row;
    if (beat.start) {
      start(pattern, now);
    }
    last_beat_ = now;
    beats_ += beats_ < kTooClose ? 1 : 0;
    bool late = false;
    if (decode_in_force_) {
      if constexpr (kOwnMemory) {
        late = late_permille != 0 && random_.between(1, 1000) <= late_permille;
        answers_.push_back({now + 3, late});
        reads_.push_back({now + 1, beat.start});
        writes_.push_back({now + 6, beat.start});
      }
      decode_beat(beat, late, now);
    }
    if (beat.line_end && beat.last_row) {
      model_.end(true);
      open_ = false;
      ends_.push_back(now + kLatency);
    }
    if (beat.line_end) {
      ++row_;
      column_ = 0;
    } else {
      column_ += 4;
    }
  }

  void start(int pattern, std::int64_t now) {
    Dut& dut = dut_.dut();
    if (may_take()) {
      dut.take_i = 1;
      dut.decode_i = decode;
      dut.bits_i = static_cast<CData>(settings.bits);
      dut.threshold_i = static_cast<CData>(settings.threshold);
      set(dut.columns_i, settings.columns);
      set(dut.rows_i, settings.rows);
      next_take_ = now + kTakeDistance;
      decode_in_force_ = decode;
      model_.configure(settings);
    }
    close_ = beats_ < kTooClose && now - last_beat_ < kTooClose && last_beat_ >= 0;
    if (close_) {
      model_.restart();
      abandoned_ += decode_in_force_ ? 1 : 0;
    }
    beats_ = 0;
    patterns_.start(now, pattern);
    open_ = true;
    lost_ = false;
    row_ = 0;
    column_ = 0;
    if (decode_in_force_) {
      due_ = model_.begin(pattern);
      if constexpr (kOwnMemory) {
        const bool busy = random_.chance(busy_percent);
        busy_.push_back({now + PatternIndex::kDelay, busy});  // counts beside the index
        if (due_ && busy) {
          model_.end(false);
          due_ = false;
          abandoned_ += close_ ? 0 : 1;
          close_ = true;
        }
      }
    } else {
      model_.restart();
      due_ = false;
    }
  }

  void decode_beat(const GrayBeat& beat, bool late, std::int64_t now) {
    if (lost_) {
      return;
    }
    std::array<std::uint16_t, 4> codes{};
    if (late) {
      lost_ = true;
      ++late_;
      abandoned_ += beat.start && close_ ? 0 : 1;  // a frame is counted once
      model_.end(false);
      if (due_) {
        breaks(now + kLatency + 1, spec::kStatusLateMemory);
      }
    } else {
      model_.pixels(row_, column_, 4, beat.pixels.data(), codes.data());
    }
    if (due_) {
      codes_.beats[now + kLatency] = {four_words(codes.data()), beat.start, beat.line_start, beat.line_end && !late};
      last_rows_.push_back({now + kLatency, beat.last_row});
    }
  }

  void answer_reads(std::int64_t now) {
    if constexpr (kOwnMemory) {
      Dut& dut = dut_.dut();
      Word128 word;
      for (std::uint32_t& part : word) {
        part = static_cast<std::uint32_t>(random_.bits());
      }
      dut.mem_late_i = random_.chance(50);  // counts only with an answer
      if (!answers_.empty() && answers_.front().clock == now) {
        dut.mem_late_i = answers_.front().late;
        word = answers_.front().late ? word : word1_;
        answers_.pop_front();
      }
      set128(dut.mem_data_i, word);
      word1_ = word0_;
    }
  }

  void write_memory() {
    if constexpr (kOwnMemory) {
      Dut& dut = dut_.dut();
      if (dut.mem_read_o != 0) {
        read_at_ = dut.mem_read_first_o != 0 ? 0 : read_at_ + 1;
        word0_ = memory_[read_at_];
      }
      if (dut.mem_write_o != 0) {
        write_at_ = dut.mem_write_first_o != 0 ? 0 : write_at_ + 1;
        memory_[write_at_] = word128(dut.mem_data_o);
      }
    }
  }

  // Takes the front of `queue` if it belongs to this clock.
  template <typename Queue>
  static auto due_now(Queue& queue, std::int64_t now) -> std::optional<typename Queue::value_type> {
    if (queue.empty() || queue.front().clock != now) {
      return std::nullopt;
    }
    auto front = queue.front();
    queue.pop_front();
    return front;
  }

  void check(std::int64_t now) {
    Dut& dut = dut_.dut();
    ASSERT_NO_FATAL_FAILURE(
        codes_.check(now, dut.codes_valid_o != 0,
                     {dut.codes_o, dut.codes_start_o != 0, dut.codes_line_start_o != 0, dut.codes_line_end_o != 0},
                     dut.codes_break_o != 0, dut.codes_status_o));
    const auto last_row = due_now(last_rows_, now);
    if (codes_.empty()) {
      ASSERT_EQ(dut.abandoned_o, static_cast<std::uint32_t>(abandoned_settled(now))) << "clock " << now;
    }
    if constexpr (kOwnMemory) {
      if (last_row) {
        ASSERT_EQ(dut.codes_last_row_o != 0, last_row->late) << "clock " << now;
      }
    }
    if constexpr (kOwnMemory) {
      const auto read = due_now(reads_, now);
      ASSERT_EQ(dut.mem_read_o != 0, read.has_value()) << "clock " << now;
      if (read) {
        ASSERT_EQ(dut.mem_read_first_o != 0, read->late) << "clock " << now;
      }
      const auto write = due_now(writes_, now);
      ASSERT_EQ(dut.mem_write_o != 0, write.has_value()) << "clock " << now;
      if (write) {
        ASSERT_EQ(dut.mem_write_first_o != 0, write->late) << "clock " << now;
      }
      bool end = false;
      while (!ends_.empty() && ends_.front() == now) {
        end = true;
        ends_.pop_front();
      }
      ASSERT_EQ(dut.mem_end_o != 0, end) << "clock " << now;
    }
  }

  // Of two breaks in one clock, that of the late memory counts, or else the first.
  void breaks(std::int64_t clock, std::uint32_t status) {
    std::uint32_t& due = codes_.breaks[clock];
    due = status == spec::kStatusLateMemory || due == 0 ? status : due;
  }

  // The count shows some clocks after the event.
  std::uint64_t abandoned_settled(std::int64_t now) { return now - last_beat_ > 8 ? abandoned_ : dut_->abandoned_o; }

  Random& random_;
  Clocked<Dut> dut_;
  model::GrayDecoder model_;
  bool decode_in_force_ = false;
  bool open_ = false;
  bool due_ = false;
  bool lost_ = false;
  bool close_ = false;  // the frame was counted as abandoned at its start
  int row_ = 0;
  int column_ = 0;
  int beats_ = kTooClose;
  std::int64_t last_beat_ = -1;
  std::int64_t next_take_ = 0;
  PatternIndex patterns_;
  CodesDue codes_;
  std::deque<Answer> answers_;
  std::deque<Answer> reads_;      // `late`: the frame's first word
  std::deque<Answer> writes_;     // likewise
  std::deque<Answer> busy_;       // likewise: busy
  std::deque<Answer> last_rows_;  // likewise: codes of a last row
  std::deque<std::int64_t> ends_;
  std::uint64_t abandoned_ = 0;
  std::uint64_t late_ = 0;

  std::vector<Word128> memory_ = std::vector<Word128>(kOwnMemory ? 1U << 16U : 0U);
  std::size_t read_at_ = 0;
  std::size_t write_at_ = 0;
  Word128 word0_{};  // requested in the previous clock
  Word128 word1_{};  // in the clock before that
};

// All m, changing settings, missing, repeated and wrong patterns, frames that break anywhere, gaps between beats and
// between frames, and also frames of one beat without any gap.
struct GrayCases {
  int max_columns = 40;
  int max_rows = 6;
  int max_bits = model::GrayDecoder::kMaxBits;
  int frames = 100;
};

template <typename Dut>
void play_gray_frames(GrayBench<Dut>& bench, const GrayCases& cases, Random& random) {
  model::GraySettings& settings = bench.settings;
  int trouble = 0;  // per mille
  int gaps = 0;     // per cent
  int spaced = 0;   // clocks
  int pattern = 0;
  std::uint32_t pending_break = 0;
  std::vector<std::uint8_t> positive;
  for (int frame = 0; frame < cases.frames && !::testing::Test::HasFatalFailure(); ++frame) {
    if (frame == 0 || random.chance(3)) {
      bench.decode = !random.chance(3);
      settings.bits = frame != 0 && random.chance(50) ? settings.bits : random.between(1, cases.max_bits);
      settings.threshold = random.chance(20) ? random.between(0, 255) : random.between(0, 12);
      settings.columns = 4 * random.between(1, random.chance(50) ? 2 : cases.max_columns / 4);
      settings.rows = random.between(1, random.chance(50) ? 2 : cases.max_rows);
      trouble = random.chance(50) ? 0 : random.between(0, 400 / settings.bits);
      gaps = random.chance(60) ? 0 : random.between(1, 60);
      spaced = random.chance(50) ? 0 : random.between(0, 12);
    }
    // A frame that does not take over the new settings has the old size; it is easier to wait.
    while (!bench.may_take()) {
      bench.clock(std::nullopt, 0, pending_break);
      pending_break = 0;
    }
    const auto size = static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns);
    if (random.between(1, 1000) <= trouble) {
      pattern = random.between(0, 2 * settings.bits - 1);
    }
    pattern %= 2 * settings.bits;
    const int shown = random.between(1, 1000) > trouble ? pattern
                      : random.chance(50)               ? random.between(0, 40)
                                                        : random.between(0, 0xFFFF);
    pattern = (pattern + 1) % (2 * settings.bits);
    std::vector<std::uint8_t> pixels = random.bytes(size);
    if (shown % 2 == 1 && positive.size() == size) {
      for (std::size_t i = 0; i < size; ++i) {  // around the threshold, on both sides
        const int edge = (pixels[i] & 1) != 0 ? settings.threshold : -settings.threshold;
        const int near = positive[i] - edge + random.between(-2, 2);
        if (random.chance(60) && near >= 0 && near <= 255) {
          pixels[i] = static_cast<std::uint8_t>(near);
        }
      }
    }
    positive = pixels;
    const std::size_t beats = size / 4;
    const std::size_t cut =
        random.between(1, 1000) <= trouble ? static_cast<std::size_t>(random.bits() % beats) : beats;
    const auto groups = static_cast<std::size_t>(settings.columns / 4);
    for (std::size_t i = 0; i < beats && i <= cut; ++i) {
      GrayBeat beat;
      std::copy_n(pixels.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, beat.pixels.begin());
      beat.start = i == 0;
      beat.line_start = i % groups == 0;
      beat.line_end = i % groups == groups - 1 && i != cut;
      beat.last_row = i / groups == static_cast<std::size_t>(settings.rows) - 1;
      bench.clock(beat, shown, pending_break);
      pending_break = 0;
      while (random.chance(gaps)) {
        bench.clock(std::nullopt, 0, 0);
      }
      if (::testing::Test::HasFatalFailure()) {
        return;
      }
    }
    if (cut < beats) {
      bench.idle(random.between(0, 3));
      pending_break =
          static_cast<std::uint32_t>(random.between(1, 7));  // with the next clock, or the next frame's start
      if (random.chance(50)) {
        bench.clock(std::nullopt, 0, std::exchange(pending_break, 0U));
      }
    }
    for (int i = spaced == 0 ? 0 : random.between(0, spaced); i > 0; --i) {
      bench.clock(std::nullopt, 0, std::exchange(pending_break, 0U));
    }
  }
  bench.clock(std::nullopt, 0, pending_break);
  bench.idle(20);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_GRAY_BENCH_H
