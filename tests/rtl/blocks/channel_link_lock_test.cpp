// Tests the training of a Channel Link's deserializer with samples: any alignment at first, single wrong samples, and
// lanes that are early or late.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "Vsp_channel_link_lock_ports.h"
#include "Vsp_channel_link_lock_twice_ports.h"
#include "tests/rtl/blocks/camera_link_bench.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kWordLatency = 3;  // clocks from the last samples of a word to the word
constexpr int kLogGood = 3;
constexpr int kGood = 1 << kLogGood;

// Lanes with random words, sampled once or twice a bit, and a deserializer whose words move by two samples with each
// rise of align_o, some clocks later.
template <typename Dut>
class LockBench {
 public:
  LockBench(std::uint64_t seed, int samples)
      : random_(seed), samples_(samples), at_(static_cast<std::int64_t>(seed % 14)) {
    dut_.valid_when({"word_o"}, [this] { return dut_->valid_o != 0; });
    for (std::size_t word = 0; word < 4; ++word) {
      words_.push_back(random_link_word(random_));
    }
    dut_->rst_i = 1;
    put_samples();
    dut_.reset();
    due_.clear();
  }

  // One clock. Returns whether error_o was high.
  bool clock() {
    put_samples();
    dut_.settle();
    check();
    const bool align = dut_->align_o != 0;
    if (align && !aligned_) {
      ++moves_;
      EXPECT_GE(since_rise_, 16) << "the deserializer has no time";
      since_rise_ = 0;
    }
    EXPECT_EQ(align, since_rise_ < 4) << "align_o is high for four clocks";
    ++since_rise_;
    EXPECT_FALSE(align && !aligned_ && locked()) << "the alignment moves in a lock";
    moving_.push_back(align && !aligned_);
    aligned_ = align;
    const bool error = dut_->error_o != 0;
    dut_.rise();
    if (moving_.size() > static_cast<std::size_t>(delay_)) {
      at_ += moving_.front() ? 2 : 0;
      moving_.pop_front();
    }
    return error;
  }

  bool error_within(int clocks) {
    for (int i = 0; i < clocks; ++i) {
      if (clock()) {
        return true;
      }
    }
    return false;
  }

  // Clocks until the lock, at most `most`; none if it does not come.
  std::optional<int> lock(int most) {
    for (int i = 0; i < most; ++i) {
      if (locked()) {
        return i;
      }
      clock();
    }
    return {};
  }

  bool locked() {
    dut_.settle();
    return dut_->locked_o != 0;
  }

  // The lane comes later by this many samples.
  void shift(int lane, int samples) { shift_[static_cast<std::size_t>(lane)] = samples; }
  // In the next clock, this sample of the lane is wrong.
  void spoil(int lane, int sample) { spoil_ = 7 * lane + sample; }
  // From now on, this many samples are skipped: the camera's clock has jumped.
  void jump(int samples) { at_ += samples; }
  void reset() {
    dut_->rst_i = 1;
    clock();
    since_rise_ = 16;
    dut_->rst_i = 0;
  }

  Random& random() { return random_; }
  [[nodiscard]] int words() const { return words_given_; }
  [[nodiscard]] int moves() const { return moves_; }
  // Clocks from a rise of align_o until the words move.
  void set_delay(int clocks) { delay_ = clocks; }

 private:
  // Sample `at` of a lane.
  bool sample(int lane, std::int64_t at) {
    const int per_word = kBitsOfLane * samples_;
    at += per_word - shift_[static_cast<std::size_t>(lane)];
    while (at >= static_cast<std::int64_t>(words_.size()) * per_word) {
      words_.push_back(random_link_word(random_));
    }
    const auto word = static_cast<std::size_t>(at / per_word);
    return lane_bit(words_[word], lane, static_cast<int>(at % per_word) / samples_);
  }

  // Seven samples of each lane, and what follows from them.
  void put_samples() {
    std::uint64_t lanes = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int i = 0; i < 7; ++i) {
        lanes |= static_cast<std::uint64_t>(sample(lane, at_ + i)) << static_cast<unsigned>(7 * lane + i);
      }
    }
    if (spoil_ >= 0) {
      lanes ^= std::uint64_t{1} << static_cast<unsigned>(spoil_);
      spoil_ = -1;
    }
    dut_->lanes_i = lanes;
    at_ += 7;
    const int per_word = kBitsOfLane * samples_;
    // Samples of word n begin at (n - 1) x per_word, because sample() adds one word.
    due_.push_back(at_ % per_word == 0 ? words_[static_cast<std::size_t>(at_ / per_word)]
                                       : std::optional<std::uint32_t>());
    if (due_.size() > kWordLatency + 1) {
      due_.pop_front();
    }
  }

  // A word at the output is one that was sent, with its last samples kWordLatency clocks ago.
  void check() {
    if (dut_->valid_o) {
      ++words_given_;
      ASSERT_EQ(due_.size(), kWordLatency + 1U);
      ASSERT_TRUE(due_.front().has_value()) << "a word where none ends";
      ASSERT_EQ(dut_->word_o, *due_.front());
    }
  }

  Random random_;
  int samples_;
  std::int64_t at_;  // the next sample
  int delay_ = 0;
  Clocked<Dut> dut_;
  std::vector<std::uint32_t> words_;
  std::array<int, kLanes> shift_{};
  int spoil_ = -1;
  std::deque<bool> moving_;
  std::deque<std::optional<std::uint32_t>> due_;
  bool aligned_ = false;
  int moves_ = 0;
  int since_rise_ = 16;  // clocks since align_o rose
  int words_given_ = 0;
};

// Every alignment at first; then every word, without a gap.
template <typename Dut>
void expect_lock_and_words(int samples) {
  std::vector<int> moves;
  for_cases(40, [&](std::uint64_t seed) {
    LockBench<Dut> bench(seed, samples);
    bench.set_delay(bench.random().between(0, 6));
    // 16 clocks for each of at most 15 movements, and the words that must be right
    const auto clocks = bench.lock(17 * 16 + (kGood + 2) * samples);
    ASSERT_TRUE(clocks.has_value());
    EXPECT_GE(*clocks, kGood * samples);
    EXPECT_EQ(bench.words(), 0) << "a word before the lock";
    moves.push_back(bench.moves());
    const int count = 100 * samples;
    EXPECT_FALSE(bench.error_within(count + 2));
    EXPECT_NEAR(bench.words(), 100, 1);
    EXPECT_EQ(bench.moves(), moves.back());
  });
  if (runs_all_cases()) {
    EXPECT_EQ(*std::min_element(moves.begin(), moves.end()), 0);
    EXPECT_GE(*std::max_element(moves.begin(), moves.end()), 6);
  }
}
TEST(ChannelLinkLock, EveryAlignment) { expect_lock_and_words<Vsp_channel_link_lock>(1); }
TEST(ChannelLinkLock, EveryAlignmentOfTwoSamples) { expect_lock_and_words<Vsp_channel_link_lock_twice>(2); }

// One wrong sample of the clock lane, or with two samples of any lane, ends the lock: that word is not given, error_o
// rises once, and the lock comes back without a movement after as many right words as at first.
template <typename Dut>
void expect_errors(int samples) {
  for_cases(30, [&](std::uint64_t seed) {
    LockBench<Dut> bench(seed, samples);
    ASSERT_TRUE(bench.lock(17 * 16 + (kGood + 2) * samples).has_value());
    bench.error_within(bench.random().between(0, 20));
    for (int round = 0; round < 20; ++round) {
      const int moves = bench.moves();
      bench.spoil(samples == 1 || round % 5 == kClockLane ? kClockLane : round % 5, bench.random().between(0, 6));
      ASSERT_FALSE(bench.error_within(kWordLatency));
      const int given = bench.words();
      ASSERT_TRUE(bench.error_within(samples));
      EXPECT_FALSE(bench.locked());
      EXPECT_EQ(bench.words(), given);
      const auto clocks = bench.lock((kGood + 2) * samples);
      ASSERT_TRUE(clocks.has_value());
      EXPECT_EQ(*clocks, kGood * samples - 1);
      EXPECT_EQ(bench.words(), given);
      EXPECT_EQ(bench.moves(), moves);
      EXPECT_FALSE(bench.error_within(bench.random().between(3, 40)));
      EXPECT_GT(bench.words(), given);
    }
  });
}
TEST(ChannelLinkLock, AWrongSampleEndsTheLock) { expect_errors<Vsp_channel_link_lock>(1); }
TEST(ChannelLinkLock, AWrongOneOfTwoSamplesEndsTheLock) { expect_errors<Vsp_channel_link_lock_twice>(2); }

// The words jump, as after a pause of the camera's clock: the lock ends at the first word, and training finds the new
// alignment.
template <typename Dut>
void expect_training_again(int samples) {
  for_cases(20, [&](std::uint64_t seed) {
    LockBench<Dut> bench(seed, samples);
    for (int round = 0; round < 10; ++round) {
      ASSERT_TRUE(bench.lock(17 * 16 + (kGood + 2) * samples).has_value());
      ASSERT_FALSE(bench.error_within(bench.random().between(5, 30)));
      bench.jump(bench.random().between(1, 7 * samples - 1));
      const int given = bench.words();
      ASSERT_TRUE(bench.error_within(kWordLatency + 2 * samples));
      EXPECT_LE(bench.words(), given + kWordLatency);
      EXPECT_FALSE(bench.locked());
      if (bench.random().chance(30)) {
        bench.reset();
        EXPECT_FALSE(bench.locked());
      }
    }
  });
}
TEST(ChannelLinkLock, TrainsAgain) { expect_training_again<Vsp_channel_link_lock>(1); }
TEST(ChannelLinkLock, TrainsAgainWithTwoSamples) { expect_training_again<Vsp_channel_link_lock_twice>(2); }

// A data lane whose second sample falls into the next bit, or whose first one falls into the bit before: no lock, and
// no word, as long as its bits change. Back in its place, it locks.
TEST(ChannelLinkLock, ALaneOutOfPlaceIsNoticed) {
  for_cases(20, [&](std::uint64_t seed) {
    LockBench<Vsp_channel_link_lock_twice> bench(seed, 2);
    for (int lane = 0; lane < kClockLane; ++lane) {
      ASSERT_TRUE(bench.lock(17 * 16 + 2 * (kGood + 2)).has_value());
      ASSERT_FALSE(bench.error_within(20));
      bench.shift(lane, bench.random().chance(50) ? 1 : -1);
      EXPECT_TRUE(bench.error_within(200));
      const int given = bench.words();
      EXPECT_FALSE(bench.lock(3000).has_value());
      EXPECT_EQ(bench.words(), given);
      bench.shift(lane, 0);
    }
  });
}

// In reset there is neither a lock nor a word nor an error.
// A clock lane that is never right: seven steps of two samples, then one by a clock, which align_o does not show.
TEST(ChannelLinkLock, EveryEighthStepExchangesTheClocks) {
  Clocked<Vsp_channel_link_lock_twice> dut;
  dut.valid_when({"word_o"}, [&] { return dut->valid_o != 0; });
  dut->lanes_i = 0;
  dut->rst_i = 1;
  dut.reset();
  std::vector<int> rises;
  for (int clock = 0, before = 0; clock < 16 * 33; ++clock) {
    dut.settle();
    if (dut->align_o != 0 && before == 0) {
      rises.push_back(clock);
    }
    before = dut->align_o;
    dut.rise();
  }
  ASSERT_GE(rises.size(), 28U);
  for (std::size_t i = 1; i < rises.size(); ++i) {
    EXPECT_NEAR(rises[i] - rises[i - 1], i % 7 == 0 ? 32 : 16, 1) << "rise " << i;
  }
}

TEST(ChannelLinkLock, ResetEndsTheLock) {
  for_cases(10, [&](std::uint64_t seed) {
    LockBench<Vsp_channel_link_lock> bench(seed, 1);
    ASSERT_TRUE(bench.lock(17 * 16 + kGood + 2).has_value());
    bench.error_within(bench.random().between(5, 15));
    bench.reset();
    EXPECT_FALSE(bench.locked());
    const int given = bench.words();
    const auto clocks = bench.lock(kGood + 20);
    ASSERT_TRUE(clocks.has_value());
    EXPECT_EQ(*clocks, kGood + 15) << "after a reset the deserializer gets time";
    EXPECT_EQ(bench.words(), given);
  });
}

}  // namespace
}  // namespace selfproj::test
