// Plays random frames through the HLS kernel of the column moments, or through that of the strongest runs, and compares
// every beat of payload with the model.
#ifndef SELFPROJ_TESTS_HLS_MOMENTS_BENCH_H
#define SELFPROJ_TESTS_HLS_MOMENTS_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "hls/column_moments.h"
#include "hls/column_runs.h"
#include "selfproj/model/little_endian.h"
#include "sim/board/hls_streams.h"
#include "tests/support/moments_frames.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

class MomentsBench {
 public:
  using Video = hls::Stream<hls::AxisBeat<32>>;
  using Payload = hls::Stream<hls::AxisBeat<128>>;
  // One step of the kernel under test.
  using Step = std::function<void(Video&, const hls::MomentsSetup&, Payload&)>;

  explicit MomentsBench(Step step) : step_(std::move(step)) {}

  // How a frame ends.
  enum class End {
    whole,
    early,  // its last beat has tlast, although no line ends there
    late,   // its last beat lacks tlast, although a line ends there
    cut,    // the next frame begins before this one has ended
  };

  // Plays the first `beats` beats of a frame. In `gaps` percent of the steps there is no beat. With End::late, `beats`
  // must be whole lines; with End::early, it must not.
  void play(const MomentsFrame& frame, int gaps, Random& random, End end = End::whole, int beats = -1) {
    const int groups = frame.columns / 4;
    const int all = groups * frame.rows;
    beats = end == End::whole ? all : beats;
    while (!video_.empty()) {  // the kernel takes the settings when it reads the first beat of a frame
      step();
    }
    setup_.columns = frame.columns;
    setup_.rows = frame.rows;
    setup_.mode = static_cast<unsigned>(frame.mode);
    setup_.threshold = frame.threshold;
    setup_.strongest = frame.select == model::Select::strongest;
    setup_.gap = static_cast<unsigned>(frame.gap);
    setup_.first_row = static_cast<unsigned>(frame.window.first);
    setup_.last_row = static_cast<unsigned>(frame.window.last);
    expect(frame, beats, end);
    for (int i = 0; i < beats; ++i) {
      while (random.chance(gaps)) {
        step();
      }
      bool last = i % groups == groups - 1;
      if (i == beats - 1 && (end == End::early || end == End::late)) {
        last = !last;
      }
      video_.write(
          hls::axis_beat<32>(model::load_little_endian<std::uint32_t>(frame.pixels.data() + 4 * i), i == 0, last));
      step();
    }
  }

  // Plays beats outside any frame.
  void stray(int beats, Random& random) {
    for (int i = 0; i < beats; ++i) {
      video_.write(hls::axis_beat<32>(static_cast<std::uint32_t>(random.bits()), false, random.chance(30)));
      step();
    }
  }

  void finish() {
    for (int i = 0; i < hls::kLanes * spec::kMaxColumns && (!video_.empty() || !expected_.empty()); ++i) {
      step();
    }
    for (int i = 0; i < 10; ++i) {
      step();
    }
    EXPECT_TRUE(expected_.empty()) << expected_.size() << " beats did not come";
  }

  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  [[nodiscard]] std::uint64_t matched() const { return matched_; }
  [[nodiscard]] std::size_t waiting() const { return expected_.size(); }
  [[nodiscard]] bool all_read() { return video_.empty(); }

 private:
  struct Beat {
    std::vector<std::uint8_t> bytes;
    bool first, last;
  };

  void expect(const MomentsFrame& frame, int beats, End end) {
    const std::vector<std::uint8_t> payload = payload_of_moments(frame);
    const int of_last_row = std::max(0, beats - (frame.rows - 1) * frame.columns / 4);
    const int words = of_last_row * (frame.mode == model::Mode::binary ? 1 : 2);
    for (int i = 0; i < words; ++i) {
      const auto from = payload.begin() + 16 * static_cast<std::ptrdiff_t>(i);
      expected_.push_back({{from, from + 16}, i == 0, end == End::whole && i == words - 1});
    }
  }

  void step() {
    step_(video_, setup_, payload_);
    ++steps_;
    hls::AxisBeat<128> beat;
    while (payload_.read_nb(beat)) {
      ASSERT_FALSE(expected_.empty()) << "more payload than expected";
      std::vector<std::uint8_t> bytes;
      sim::append_beat(beat, bytes);
      ASSERT_EQ(bytes, expected_.front().bytes);
      ASSERT_EQ(beat.user != 0, expected_.front().first);
      ASSERT_EQ(beat.last != 0, expected_.front().last);
      ASSERT_EQ(beat.keep.to_uint(), 0xFFFFU);
      expected_.pop_front();
      ++matched_;
    }
  }

  Step step_;
  Video video_;
  Payload payload_;
  hls::MomentsSetup setup_;
  std::deque<Beat> expected_;
  std::uint64_t steps_ = 0;
  std::uint64_t matched_ = 0;
};

// Plays `frames` frames of changing size, mode and threshold. Some of them break, and stray beats may follow. Gaps may
// come anywhere.
inline void play_moments_frames(MomentsBench& bench, int frames, Random& random, bool runs = false) {
  int columns = 4;
  int rows = 1;
  model::Mode mode = model::Mode::binary;
  const int breaks = random.chance(50) ? 0 : random.between(1, 40);
  const bool dense = random.chance(50);
  for (int i = 0; i < frames && !::testing::Test::HasFatalFailure(); ++i) {
    if (i == 0 || random.chance(30)) {
      columns = 4 * random.between(1, random.chance(50) ? 3 : 16);
      rows = random.between(1, random.chance(50) ? 2 : 9);
      mode = static_cast<model::Mode>(random.between(0, 2));
    }
    const MomentsFrame frame = random_moments_frame(random, columns, rows, mode, runs);
    const int groups = columns / 4;
    const int gaps = dense ? 0 : random.between(0, 60);
    if (!random.chance(breaks)) {
      bench.play(frame, gaps, random);
      continue;
    }
    const int row = random.chance(60) ? rows : random.between(1, rows);
    const int kind = random.between(0, 2);
    if (kind == 0 && groups > 1) {
      bench.play(frame, gaps, random, MomentsBench::End::early, (row - 1) * groups + random.between(1, groups - 1));
      bench.stray(random.between(0, 5), random);
    } else if (kind == 1) {
      bench.play(frame, gaps, random, MomentsBench::End::late, row * groups);
      bench.stray(random.between(0, 5), random);
    } else if (rows * groups > 1) {
      bench.play(frame, gaps, random, MomentsBench::End::cut,
                 std::min((row - 1) * groups + random.between(1, groups), rows * groups - 1));
    }
  }
  bench.finish();
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HLS_MOMENTS_BENCH_H
