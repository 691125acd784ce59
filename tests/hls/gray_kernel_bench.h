// Plays random sequences of frames through the kernel of the Gray-code decoder, and compares every code with the model.
#ifndef SELFPROJ_TESTS_HLS_GRAY_KERNEL_BENCH_H
#define SELFPROJ_TESTS_HLS_GRAY_KERNEL_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <set>
#include <utility>
#include <vector>

#include "hls/gray_decoder.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/little_endian.h"
#include "selfproj/model/median3x3.h"
#include "tests/rtl/blocks/code_beats.h"
#include "tests/support/random_cases.h"
#include "tests/support/reference_gray.h"

namespace selfproj::test {

class GrayKernelBench {
 public:
  using Video = hls::Stream<hls::AxisBeat<32>>;
  using Codes = hls::Stream<hls::AxisBeat<64>>;
  using Step = std::function<void(Video&, const hls::GraySetup&, hls::PatternIndex, Codes&)>;

  explicit GrayKernelBench(Step step) : step_(std::move(step)), model_({.rows = 1, .columns = 4, .bits = 1}) {}

  // Plays a frame. In `gaps` percent of the steps there is no beat. A frame that is not good breaks after some of its
  // beats, in one of three ways.
  void play(const model::GraySettings& settings, bool median, const GrayFrame& frame, int gaps, Random& random) {
    model_.configure(settings);
    setup_.columns = settings.columns;
    setup_.rows = settings.rows;
    setup_.bits = settings.bits;
    setup_.threshold = settings.threshold;
    setup_.median = median;
    const int groups = settings.columns / 4;
    const int all = groups * settings.rows;
    // A frame without an end breaks when the next one starts, in the model as well.
    model_.end(!std::exchange(cut_, false));
    const bool due = model_.begin(frame.pattern);
    expect(settings, median, due, frame);
    int beats = all;
    bool swaps_last = false;
    if (!frame.good) {
      beats = random.between(1, all);
      swaps_last = beats == all || random.chance(60);
      cut_ = !swaps_last;
    }
    for (int i = 0; i < beats; ++i) {
      while (random.chance(gaps)) {
        step(frame.pattern);
      }
      const auto pixels = model::load_little_endian<std::uint32_t>(frame.pixels.data() + 4 * i);
      const bool last = (i % groups == groups - 1) != (swaps_last && i == beats - 1);
      video_.write(hls::axis_beat<32>(pixels, i == 0, last));
      do {  // pattern and settings count when the frame's start is read
        step(frame.pattern);
      } while (!video_.empty() && !::testing::Test::HasFatalFailure());
    }
    if (due && !frame.good) {
      broken_.insert(images_);  // what has not left by now may be missing
    }
    if (!cut_) {
      model_.end(frame.good);
    }
    if (swaps_last) {
      drop_broken();
      for (int i = random.between(0, 4); i > 0; --i) {  // beats outside any frame
        video_.write(hls::axis_beat<32>(static_cast<std::uint32_t>(random.bits()), false, random.chance(30)));
        step(0);
      }
    }
  }

  void idle(int steps) {
    for (int i = 0; i < steps; ++i) {
      step(0);
    }
  }

  // Runs until everything is out.
  void finish(int columns) {
    idle(columns / 4 + 8);
    drop_broken();
    EXPECT_TRUE(expected_.empty()) << expected_.size() << " beats did not come";
  }

  [[nodiscard]] std::uint64_t pixels() const { return 4 * matched_; }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

 private:
  struct Beat {
    std::uint64_t words;
    bool start, line_end;
    int image;
  };

  void expect(const model::GraySettings& settings, bool median, bool due, const GrayFrame& frame) {
    std::vector<std::uint16_t> codes(frame.pixels.size());
    for (int row = 0; row < settings.rows; ++row) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(row) * settings.columns;
      model_.pixels(row, 0, settings.columns, frame.pixels.data() + at, codes.data() + at);
    }
    if (!due) {
      return;
    }
    ++images_;
    if (median) {
      std::vector<std::uint16_t> filtered(codes.size());
      model::median3x3(codes.data(), settings.rows, settings.columns, filtered.data());
      codes = filtered;
    }
    const auto groups = static_cast<std::size_t>(settings.columns) / 4;
    for (std::size_t i = 0; i < codes.size() / 4; ++i) {
      expected_.push_back({four_words(codes.data() + 4 * i), i == 0, i % groups == groups - 1, images_});
    }
  }

  void drop_broken() {
    while (!expected_.empty() && broken_.contains(expected_.front().image)) {
      expected_.pop_front();
    }
  }

  void step(int pattern) {
    step_(video_, setup_, pattern, codes_);
    ++steps_;
    hls::AxisBeat<64> beat;
    while (codes_.read_nb(beat)) {
      if (beat.user != 0) {
        drop_broken();
      }
      ASSERT_FALSE(expected_.empty()) << "more codes than expected";
      ASSERT_EQ(beat.data.to_uint64(), expected_.front().words);
      ASSERT_EQ(beat.user != 0, expected_.front().start);
      ASSERT_EQ(beat.last != 0, expected_.front().line_end);
      expected_.pop_front();
      ++matched_;
    }
  }

  Step step_;
  Video video_;
  Codes codes_;
  hls::GraySetup setup_;
  model::GrayDecoder model_;
  bool cut_ = false;
  int images_ = 0;        // code images so far
  std::set<int> broken_;  // those that broke
  std::deque<Beat> expected_;
  std::uint64_t matched_ = 0;
  std::uint64_t steps_ = 0;
};

inline model::GraySettings random_gray_settings(Random& random) {
  const int rows = random.between(1, random.chance(50) ? 2 : 16);
  const int columns = 4 * random.between(1, random.chance(50) ? 3 : 16);
  const int bits = random.between(1, model::GrayDecoder::kMaxBits);
  return {.rows = rows,
          .columns = columns,
          .bits = bits,
          .threshold = random.chance(20) ? random.between(0, 255) : random.between(0, 12)};
}

// Another value for one of them
inline void change_one(model::GraySettings& settings, Random& random) {
  const model::GraySettings other = random_gray_settings(random);
  switch (random.between(0, 3)) {
    case 0:
      settings.rows = other.rows;
      break;
    case 1:
      settings.columns = other.columns;
      break;
    case 2:
      settings.bits = other.bits;
      break;
    default:
      settings.threshold = other.threshold;
      break;
  }
}

// Plays several sequences with settings of their own: all m, differences around the threshold, frames that are missing,
// come twice, have wrong indices or break, gaps, and one setting that changes while the patterns go on.
inline void play_gray_sequences(GrayKernelBench& bench, int sequences, int frames, Random& random) {
  int columns = 4;
  for (int i = 0; i < sequences && !::testing::Test::HasFatalFailure(); ++i) {
    model::GraySettings settings = random_gray_settings(random);
    GraySequence sequence(settings, random);
    const bool median = random.chance(60);
    const int gaps = random.chance(60) ? 0 : random.between(1, 60);
    for (int frame = 0; frame < frames && !::testing::Test::HasFatalFailure(); ++frame) {
      if (random.chance(2)) {
        change_one(settings, random);
        sequence.configure(settings);
      }
      bench.play(settings, median, sequence.next(), gaps, random);
    }
    columns = settings.columns;
    if (random.chance(50)) {
      bench.idle(random.between(1, 60));
    }
  }
  bench.finish(columns);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HLS_GRAY_KERNEL_BENCH_H
