// Sends frames into the column moments, plain or of the strongest runs, as sp_frame_tracker does, accepts them as
// sp_packetizer does, and compares every word with the model in the clock that the headers of sp_column_moments and
// sp_column_runs state.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_COLUMN_MOMENTS_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_COLUMN_MOMENTS_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "selfproj/model/little_endian.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/moments_frames.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::moments {

constexpr int kAcceptDelay = 4;     // from the first beat of the last row to accept_i
constexpr int kBusyAfter = 7;       // sp_packetizer: from a packet's last payload beat to the next decision
constexpr int kGreyFirstDelay = 6;  // from a beat to its read by the drain; and from there:

// The circuit has the strongest runs built in.
template <typename Dut>
constexpr bool kRuns = requires(Dut& dut) {
  dut.strongest_i;
};

// From that read to the first half of the group; the other half comes one clock later.
template <typename Dut>
constexpr int kDrainDelay = kRuns<Dut> ? 13 : 10;

// From a beat to its word in mode binary, where it does not go through the drain. A break comes one clock after its
// beat.
template <typename Dut>
constexpr int kBinaryDelay = 10;  // of a grey build

// Mode binary goes through the drain.
template <typename Dut>
constexpr bool kBinaryDrains = false;

// Bits of a pixel.
template <typename Dut>
constexpr int kPixelBits = 8;

// Pixels of a beat, which are the columns of a group.
template <typename Dut>
constexpr int kLanes = 4;

struct Frame : MomentsFrame {
  int gaps = 0;        // percent of clocks without a beat
  bool wanted = true;  // its packet is taken if possible
  int stop_row = 0;    // the frame breaks after `stop_beats` beats of this row; 0: it does not break
  int stop_beats = 0;
  int break_after = 1;  // clocks from its last beat to break_i
  // filled in by the bench
  std::vector<std::uint8_t> words = {};
  std::optional<bool> accepted = {};
  int words_sent = 0;
  std::int64_t last_drain = INT64_MIN / 2;
  std::int64_t last_word = INT64_MIN / 2;
};

template <typename Dut>
class ColumnBench {
 public:
  explicit ColumnBench(Random& random) : random_(random) {
    moments_.valid_when({"moments_data_o"}, [this] { return moments_->moments_valid_o != 0; });
    moments_->beat_valid_i = 0;
    moments_->break_i = 0;
    moments_->accept_i = 0;
    moments_.reset();
  }

  // Plays a frame up to its last beat.
  void play(Frame settings) {
    auto frame = std::make_shared<Frame>(std::move(settings));
    frame->words = payload_of_moments(*frame);
    const int groups = frame->columns / kColumns;
    for (int row = 1; row <= frame->rows; ++row) {
      for (int group = 0; group < groups; ++group) {
        while (frame->gaps > 0 && random_.chance(frame->gaps)) {
          clock();
        }
        const bool stops = row == frame->stop_row && group + 1 == frame->stop_beats;
        beat(frame, row, group, stops);
        if (::testing::Test::HasFatalFailure()) {
          return;
        }
        if (stops) {
          if (row == frame->rows) {
            breaks_.push_back({moments_.clock() - 1 + frame->break_after, frame});
          }
          return;
        }
      }
    }
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks && !::testing::Test::HasFatalFailure(); ++i) {
      clock();
    }
  }

  // Runs until all expected words have left.
  void finish() {
    while (!::testing::Test::HasFatalFailure() &&
           (!expected_.empty() || !last_row_.empty() || !breaks_.empty() || !decisions_.empty())) {
      clock();
    }
    idle(20);
  }

  // Waits until the next frame's packet can be taken, if its last row begins `ahead` clocks from now or later.
  void wait_for_room(int ahead) {
    while (!::testing::Test::HasFatalFailure() &&
           (!decisions_.empty() || moments_.clock() + ahead + kAcceptDelay - 1 < idle_from_)) {
      clock();
    }
  }

  std::int64_t now() const { return moments_.clock(); }
  bool frame_is_breaking() const { return !breaks_.empty(); }

  int frames_accepted = 0;
  int frames_spoiled = 0;
  int frames_refused = 0;
  int words_matched = 0;
  std::int64_t last_beat_clock = 0;
  std::int64_t last_word_clock = 0;

 private:
  static constexpr int kColumns = kLanes<Dut>;
  static constexpr int kBits = kPixelBits<Dut>;
  static constexpr int kMaxPixel = (1 << kBits) - 1;
  using Word = std::array<std::uint32_t, static_cast<std::size_t>(kColumns)>;  // what leaves in a clock

  struct Output {
    std::optional<Word> word;
    bool ends_early = false;
  };
  struct LastRowBeat {
    std::int64_t clock;
    int group;
    std::shared_ptr<Frame> frame;
  };
  struct Break {
    std::int64_t clock;
    std::shared_ptr<Frame> frame;
  };

  static Word word_at(const Frame& frame, int index) {
    Word word{};
    for (std::size_t i = 0; i < 4 * word.size(); ++i) {
      const auto at = 4 * word.size() * static_cast<std::size_t>(index) + i;
      word[i / 4] |= static_cast<std::uint32_t>(frame.words[at]) << (8 * (i % 4));
    }
    return word;
  }

  // The pixels of a beat, leftmost lowest.
  template <typename Pixel>
  void set_pixels(const Pixel& pixel) {
    std::array<std::uint32_t, (kColumns * kBits + 31) / 32> words{};
    for (std::size_t bit = 0; bit < kColumns * kBits; ++bit) {
      words[bit / 32] |= (pixel(bit / kBits) >> bit % kBits & 1U) << bit % 32;
    }
    auto& port = moments_->beat_pixels_i;
    using Port = std::remove_reference_t<decltype(port)>;
    if constexpr (std::is_integral_v<Port>) {
      std::uint64_t all = words[0];
      if constexpr (words.size() > 1) {
        all |= std::uint64_t{words[1]} << 32;
      }
      port = static_cast<Port>(all);
    } else {
      for (std::size_t i = 0; i < words.size(); ++i) {
        port[i] = words[i];
      }
    }
  }

  void beat(const std::shared_ptr<Frame>& frame, int row, int group, bool broken) {
    const int groups = frame->columns / kColumns;
    const auto at = static_cast<std::size_t>(row - 1) * static_cast<std::size_t>(frame->columns) +
                    static_cast<std::size_t>(kColumns * group);
    moments_->beat_valid_i = 1;
    set_pixels([&](std::size_t lane) -> std::uint32_t {
      return kBits > 8 ? frame->wide_pixels[at + lane] : frame->pixels[at + lane];
    });
    moments_->beat_group_i = static_cast<std::remove_reference_t<decltype(moments_->beat_group_i)>>(group);
    moments_->beat_row_i = static_cast<std::remove_reference_t<decltype(moments_->beat_row_i)>>(row);
    moments_->beat_first_row_i = row == 1;
    moments_->beat_last_row_i = row == frame->rows;
    moments_->beat_line_end_i = !broken && group == groups - 1;
    if constexpr (kRuns<Dut>) {
      moments_->strongest_i = frame->select == model::Select::strongest;
      moments_->gap_i = static_cast<CData>(frame->gap);
    } else {
      moments_->one_group_i = groups == 1;
      moments_->two_groups_i = groups == 2;
    }
    moments_->mode_i = static_cast<CData>(frame->mode);
    moments_->threshold_i = static_cast<std::remove_reference_t<decltype(moments_->threshold_i)>>(
        frame->window.counts(row) ? frame->threshold : kMaxPixel);  // as sp_moments_path
    if (row == frame->rows) {
      if (group == 0) {
        decisions_.push_back({moments_.clock() + kAcceptDelay - 1, frame});
      }
      last_row_.push_back({moments_.clock(), group, frame});
      last_beat_clock = moments_.clock();
    }
    step();
    moments_->beat_valid_i = 0;
    const std::uint64_t anything = random_.bits();
    set_pixels([&](std::size_t lane) { return static_cast<std::uint32_t>(anything >> lane & kMaxPixel); });
  }

  void clock() { step(); }

  void step() {
    const std::int64_t now = moments_.clock();
    SCOPED_TRACE(::testing::Message() << "clock " << now);
    if (next_accept_) {
      accept_ = *next_accept_;
      next_accept_.reset();
    }
    moments_->accept_i = accept_;
    moments_->break_i = 0;
    for (const Break& b : breaks_) {
      if (b.clock == now) {
        moments_->break_i = 1;
      }
    }
    moments_.settle();
    // four clocks after a beat of a last row the decision about its frame is known
    while (!last_row_.empty() && last_row_.front().clock + kAcceptDelay == now) {
      const LastRowBeat beat = last_row_.front();
      last_row_.erase(last_row_.begin());
      if (*beat.frame->accepted) {
        expect_words(*beat.frame, beat.clock, beat.group);
      }
    }
    while (!breaks_.empty() && breaks_.front().clock + 3 == now) {
      const Break b = breaks_.front();
      breaks_.erase(breaks_.begin());
      if (*b.frame->accepted) {
        expect_break(*b.frame, b.clock);
      }
    }
    while (!decisions_.empty() && decisions_.front().clock == now) {
      Frame& frame = *decisions_.front().frame;
      const bool spoiled = moments_->spoiled_o != 0;
      frames_spoiled += spoiled ? 1 : 0;
      frame.accepted = frame.wanted && now >= idle_from_ && !spoiled;
      (*frame.accepted ? frames_accepted : frames_refused) += 1;
      if (*frame.accepted) {
        idle_from_ = INT64_MAX;
      }
      next_accept_ = frame.accepted;
      decisions_.erase(decisions_.begin());
    }
    const auto found = expected_.find(now);
    const Output output = found == expected_.end() ? Output{} : found->second;
    ASSERT_EQ(moments_->moments_valid_o, output.word ? 1 : 0);
    if (output.word) {
      Word word;
      for (std::size_t i = 0; i < word.size(); ++i) {
        word[i] = moments_->moments_data_o[i];
      }
      ASSERT_EQ(word, *output.word);
      ++words_matched;
      last_word_clock = now;
    }
    ASSERT_EQ(moments_->moments_break_o, output.ends_early ? 1 : 0);
    if (found != expected_.end()) {
      expected_.erase(found);
    }
    moments_.rise();
  }

  static bool drains(const Frame& frame) { return frame.mode != model::Mode::binary || kBinaryDrains<Dut>; }

  void expect_words(Frame& frame, std::int64_t clock, int group) {
    if (drains(frame)) {
      frame.last_drain = std::max(clock + kGreyFirstDelay, frame.last_drain + 2);
      frame.last_word = frame.last_drain + kDrainDelay<Dut> + 1;
    } else {
      frame.last_word = clock + kBinaryDelay<Dut>;
    }
    if (frame.mode == model::Mode::binary) {
      expected_[frame.last_word].word = word_at(frame, group);
      ++frame.words_sent;
    } else {
      expected_[frame.last_word - 1].word = word_at(frame, 2 * group);
      expected_[frame.last_word].word = word_at(frame, 2 * group + 1);
      frame.words_sent += 2;
    }
    if (frame.stop_row == 0 && frame.words_sent == static_cast<int>(frame.words.size()) / (4 * kColumns)) {
      idle_from_ = frame.last_word + kBusyAfter;
    }
  }

  void expect_break(const Frame& frame, std::int64_t clock) {
    const std::int64_t when = drains(frame)
                                  ? std::max(clock + kGreyFirstDelay - 1, frame.last_drain + 2) + kDrainDelay<Dut>
                                  : clock + kBinaryDelay<Dut> - 1;
    ASSERT_GE(when, frame.last_word);
    expected_[when].ends_early = true;
    const int missing = static_cast<int>(frame.words.size()) / (4 * kColumns) - frame.words_sent;
    idle_from_ = (missing > 0 ? when + missing : frame.last_word) + kBusyAfter;
  }

  Random& random_;
  Clocked<Dut> moments_;
  std::map<std::int64_t, Output> expected_;  // by clock
  std::vector<LastRowBeat> last_row_;
  std::vector<Break> breaks_, decisions_;
  std::optional<bool> next_accept_;
  bool accept_ = false;
  std::int64_t idle_from_ = 0;
};

template <typename Dut>
Frame random_frame(Random& random, int columns, int rows, model::Mode mode) {
  Frame frame;
  static_cast<MomentsFrame&>(frame) = random_moments_frame(random, columns, rows, mode, kRuns<Dut>);
  if (const int bits = kPixelBits<Dut>; bits > 8) {
    widen(random, bits, frame);
  }
  return frame;
}

// All small sizes; each frame comes as soon as the packet of the previous one allows it.
template <typename Dut>
void small_sizes(const std::vector<model::Mode>& modes) {
  Random random(1);
  for (const model::Mode mode : modes) {
    for (int columns = kLanes<Dut>; columns <= 8 * kLanes<Dut>; columns += kLanes<Dut>) {
      for (int rows = 1; rows <= 7; ++rows) {
        SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode));
        ColumnBench<Dut> bench(random);
        for (int frame = 0; frame < 8; ++frame) {
          Frame next = random_frame<Dut>(random, columns, rows, mode);
          next.gaps = frame < 5 ? 0 : 40;
          bench.wait_for_room((rows - 1) * columns / kLanes<Dut>);
          bench.play(next);
          ASSERT_FALSE(::testing::Test::HasFatalFailure());
        }
        bench.finish();
        ASSERT_EQ(bench.frames_accepted, 8);
        ASSERT_EQ(bench.frames_spoiled, 0);
      }
    }
  }
}

// The largest pixels in the largest images, so that every sum takes its largest value.
template <typename Dut>
void large_size(int columns, int rows, const std::vector<model::Mode>& modes) {
  Random random(1);
  for (const model::Mode mode : modes) {
    SCOPED_TRACE(::testing::Message() << columns << " x " << rows << ", mode " << static_cast<int>(mode));
    ColumnBench<Dut> bench(random);
    Frame frame = random_frame<Dut>(random, columns, rows, mode);
    frame.threshold = 0;
    frame.window = {};
    std::fill(frame.pixels.begin(), frame.pixels.end(), std::uint8_t{255});
    std::fill(frame.wide_pixels.begin(), frame.wide_pixels.end(), static_cast<std::uint16_t>((1 << frame.bits) - 1));
    bench.play(frame);
    frame = random_frame<Dut>(random, columns, rows, mode);
    bench.play(frame);  // immediately after it
    bench.finish();
    ASSERT_EQ(bench.frames_accepted, 2);
    ASSERT_EQ(bench.frames_spoiled, 0);
  }
}

// Frames of one size without gaps between them but with gaps inside. Some are refused, some break in their last row or
// earlier.
template <typename Dut>
void random_frames(Random& random, const std::vector<model::Mode>& modes, int max_columns, int max_rows,
                   bool sizes_change) {
  ColumnBench<Dut> bench(random);
  constexpr int kColumns = kLanes<Dut>;
  int columns = kColumns;
  int rows = 1;
  model::Mode mode = model::Mode::binary;
  const int breaks = random.chance(50) ? 0 : random.between(1, 40);
  const bool dense = random.chance(50);
  for (int i = 0; i < 40; ++i) {
    if (i == 0 || (sizes_change && random.chance(50))) {
      columns = kColumns * random.between(1, max_columns / kColumns);
      columns = random.chance(40) ? kColumns * random.between(1, 3) : columns;
      rows = random.between(1, max_rows);
      mode = modes[static_cast<std::size_t>(random.between(0, static_cast<int>(modes.size()) - 1))];
    }
    Frame frame = random_frame<Dut>(random, columns, rows, mode);
    frame.gaps = dense ? 0 : random.between(0, 70);
    frame.wanted = random.chance(85);
    if (random.chance(breaks)) {
      frame.stop_row = random.chance(70) ? rows : random.between(1, rows);
      frame.stop_beats = random.between(1, columns / kColumns);
      // A line of one group is over with its beat: its frame breaks at once.
      const bool at_once = random.chance(60) || (columns == kColumns && !sizes_change);
      frame.break_after = at_once ? 1 : random.between(1, 15);
    }
    bench.play(frame);
    ASSERT_FALSE(::testing::Test::HasFatalFailure()) << "frame " << i;
    // the next frame begins immediately, with the break, or later
    if (frame.stop_row == rows) {
      bench.idle(frame.break_after - 1 + (random.chance(50) ? 0 : 1));
    }
    bench.idle(random.chance(60) ? 0 : random.between(1, 40));
    ASSERT_FALSE(::testing::Test::HasFatalFailure()) << "frame " << i;
  }
  bench.finish();
  EXPECT_GT(bench.words_matched, 0);
  if (!sizes_change) {
    EXPECT_EQ(bench.frames_spoiled, 0);
  }
}

// Clocks from the last pixel of a frame without gaps to the frame's last word.
template <typename Dut>
std::int64_t delay_of(int columns, model::Mode mode) {
  Random random(1);
  ColumnBench<Dut> bench(random);
  bench.play(random_frame<Dut>(random, columns, 3, mode));
  bench.finish();
  return bench.last_word_clock - bench.last_beat_clock;
}

// A frame of three rows comes while a much larger one still drains. Its sums are void, spoiled_o says so, and its
// packet is not accepted; the next frame is right. (A busy packetizer usually refuses such a frame anyway. It does not
// if the drain is long and the frame is narrow with many rows.)
template <typename Dut>
void spoiled_frame() {
  Random random(1);
  ColumnBench<Dut> bench(random);
  constexpr int kTwoGroups = 2 * kLanes<Dut>;
  bench.play(random_frame<Dut>(random, 2048, 2, model::Mode::grey));
  bench.play(random_frame<Dut>(random, kTwoGroups, 400, model::Mode::grey));  // its second row collides with the drain
  EXPECT_EQ(bench.frames_accepted, 1);
  bench.idle(5);
  EXPECT_EQ(bench.frames_spoiled, 1);
  bench.idle(600);
  bench.play(random_frame<Dut>(random, kTwoGroups, 400, model::Mode::grey));
  bench.finish();
  EXPECT_EQ(bench.frames_accepted, 2);
  EXPECT_EQ(bench.frames_spoiled, 1);
}

}  // namespace selfproj::test::moments

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_COLUMN_MOMENTS_BENCH_H
