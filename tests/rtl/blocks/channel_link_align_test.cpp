// Tests the phase alignment of a Channel Link with samples: an eye says what the clock lane brings at each tap of the
// delay, and the tap that is to be found follows from it.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "Vsp_channel_link_align_ports.h"
#include "tests/rtl/blocks/camera_link_bench.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The parameters of the build
constexpr int kTaps = 12;
constexpr int kSettle = 5;
constexpr int kWindow = 8;
constexpr int kRightWords = 4;
constexpr int kPatience = 64;

constexpr int kLatency = 5;                      // clocks from the one in which a word begins to the word
constexpr int kAtATap = kSettle + kWindow + 13;  // clocks
constexpr int kToGiveUp = 11;                    // clocks from the load of a tap until it is given up, besides
constexpr int kToLoad = 5;                       // clocks from the end of the patience
constexpr int kToLock = kSettle + kRightWords + 20;
constexpr int kSearch = kTaps * kAtATap + 8 * kTaps + kToLock;

// What the clock lane brings at a tap.
struct Eye {
  enum Kind { good, noise, wrong, low, high };
  Kind kind = noise;
  int turn = 0;  // samples of a clock that belong to the word before
  int bit = 0;   // the wrong one
};
using Eyes = std::array<Eye, kTaps>;

// The middle of the widest eye, from the first to the last good tap of one turn; of equal ones the first; -1 without a
// good tap.
int middle_of(const Eyes& eyes) {
  int best = 0;
  int middle = -1;
  int first = 0;
  int turn = -1;
  for (int tap = 0; tap < kTaps; ++tap) {
    const Eye& eye = eyes[static_cast<std::size_t>(tap)];
    if (eye.kind != Eye::good) {
      continue;
    }
    if (eye.turn != turn) {
      first = tap;
      turn = eye.turn;
    }
    if (tap - first + 1 > best) {
      best = tap - first + 1;
      middle = first + best / 2;
    }
  }
  return middle;
}

// Up to two edges of a bit, each as wide as one to three taps, between which the turn changes; other taps may be bad.
Eyes any_eyes(Random& random) {
  Eyes eyes;
  int turn = random.between(0, 6);
  int next = random.between(0, 6);
  for (int tap = 0; tap < kTaps; ++tap) {
    Eye& eye = eyes[static_cast<std::size_t>(tap)];
    eye = {Eye::good, turn, random.between(0, 6)};
    if (tap >= next) {
      const bool crossed = random.chance(50);
      eye.kind = random.chance(30) ? Eye::wrong : random.chance(30) ? Eye::good : Eye::noise;
      if (crossed) {
        turn = (turn + 1) % 7;
        next = tap + random.between(1, 8);
      }
    }
  }
  if (random.chance(30)) {
    eyes[static_cast<std::size_t>(random.between(0, 11))].kind = Eye::noise;  // a disturbance
  }
  return eyes;
}

bool locks(const Eyes& eyes) {
  const int middle = middle_of(eyes);
  return middle >= 0 && eyes[static_cast<std::size_t>(middle)].kind == Eye::good;
}

Eyes eyes_that_lock(Random& random) {
  Eyes eyes = any_eyes(random);
  while (!locks(eyes)) {
    eyes = any_eyes(random);
  }
  return eyes;
}

class AlignBench {
 public:
  explicit AlignBench(std::uint64_t seed) : random_(seed) {
    dut_.valid_when({"word_o"}, [this] { return dut_->valid_o != 0; });
    for (int word = 0; word < 8; ++word) {
      words_.push_back(random_link_word(random_));
    }
    dut_->lanes_i = 0;
    dut_.reset();
  }

  Eyes eyes;  // now

  void clock() {
    put_samples();
    dut_.settle();
    check_pulses();
    check_word();
    errors_ += dut_->error_o;
    locked_ = dut_->locked_o != 0;
    dut_.rise();
    ++clock_;
  }
  void clocks(int count) {
    for (int i = 0; i < count; ++i) {
      clock();
    }
  }
  // Until it is locked; false after this many clocks.
  bool lock(int most) {
    for (int i = 0; i < most; ++i) {
      clock();
      if (locked_) {
        return true;
      }
    }
    return false;
  }

  // A clock of reset, after which nothing is high. A pulse that it cuts off does not count.
  void reset() {
    dut_->rst_i = 1;
    put_samples();
    dut_.tick();
    dut_->rst_i = 0;
    dut_.settle();
    EXPECT_FALSE(dut_->tap_load_o || dut_->tap_move_o || dut_->locked_o || dut_->valid_o || dut_->error_o);
    locked_ = false;
    high_ = 0;
    low_ = 4;
  }

  // In the next clock, the clock lane brings these samples.
  void spoil(unsigned samples) { spoil_ = static_cast<int>(samples); }
  void all(Eye eye) { eyes.fill(eye); }
  // All taps bring this, with the words where they are.
  void all(Eye::Kind kind) { eyes.fill({kind, eyes[static_cast<std::size_t>(tap_)].turn}); }

  [[nodiscard]] std::uint64_t clock_number() const { return clock_; }
  [[nodiscard]] bool locked() const { return locked_; }
  [[nodiscard]] unsigned clock_lane() const { return clock_lane_; }
  [[nodiscard]] int errors() const { return errors_; }
  [[nodiscard]] int words() const { return words_given_; }
  [[nodiscard]] int pulses() const { return pulses_; }
  [[nodiscard]] int loads() const { return static_cast<int>(load_clocks_.size()); }
  [[nodiscard]] const std::vector<std::uint64_t>& load_clocks() const { return load_clocks_; }
  [[nodiscard]] int tap() const { return tap_; }

 private:
  // A word begins `turn` samples after the beginning of this clock's samples.
  void put_samples() {
    if (to_show_ > 0 && --to_show_ == 0) {
      shown_ = tap_;
    }
    const Eye eye = eyes[static_cast<std::size_t>(shown_)];
    words_.push_back(random_link_word(random_));
    const std::size_t now = words_.size() - 4;
    std::uint64_t lanes = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int i = 0; i < kBitsOfLane; ++i) {
        const int at = i - eye.turn;
        const bool bit = lane_bit(words_[at < 0 ? now - 1 : now], lane, at < 0 ? at + kBitsOfLane : at);
        lanes |= static_cast<std::uint64_t>(bit) << static_cast<unsigned>(kBitsOfLane * lane + i);
      }
    }
    constexpr unsigned kAt = kBitsOfLane * kClockLane;
    std::uint64_t wrong = 0;
    if (eye.kind == Eye::wrong) {
      wrong ^= 1U << static_cast<unsigned>(eye.bit);  // any of 1100011: never the pattern, however turned
    } else if (eye.kind == Eye::noise && clock_ % 3 == 0) {
      wrong ^= 1U << static_cast<unsigned>(random_.between(0, 6));
    }
    lanes ^= wrong << kAt;
    constexpr std::uint64_t kClock = std::uint64_t{0x7f} << kAt;
    clock_lane_ = static_cast<unsigned>(lanes >> kAt & 0x7fU);
    if (eye.kind == Eye::low) {
      lanes &= ~kClock;
    } else if (eye.kind == Eye::high) {
      lanes |= kClock;
    } else if (spoil_ >= 0) {
      lanes = (lanes & ~kClock) | static_cast<std::uint64_t>(spoil_) << kAt;
    }
    spoil_ = -1;
    dut_->lanes_i = lanes;
    if (words_.size() > 32) {
      words_.pop_front();
    }
  }

  // Each pulse is high for four clocks, and low for at least four before the next. The tap shows kSettle clocks after
  // its fall, and not sooner.
  void check_pulses() {
    const bool load = dut_->tap_load_o != 0;
    const bool move = dut_->tap_move_o != 0;
    ASSERT_FALSE(load && move);
    if (load || move) {
      ASSERT_TRUE(high_ > 0 || low_ >= 4);
      pulses_ += high_ == 0 ? 1 : 0;
      if (load && high_ == 0) {
        load_clocks_.push_back(clock_);
      }
      ++high_;
      low_ = 0;
      loads_now_ = load;
    } else {
      if (high_ > 0) {
        ASSERT_EQ(high_, 4);
        tap_ = loads_now_ ? 0 : tap_ + 1;
        ASSERT_LT(tap_, kTaps);
        to_show_ = kSettle;
      }
      high_ = 0;
      ++low_;
    }
    ASSERT_FALSE((load || move) && dut_->locked_o);
  }

  // A word at the output is the one that began kLatency clocks ago.
  void check_word() {
    if (dut_->valid_o) {
      ++words_given_;
      ASSERT_TRUE(dut_->locked_o);
      ASSERT_EQ(dut_->word_o, words_[words_.size() - 4 - kLatency]);
    }
  }

  Random random_;
  Clocked<Vsp_channel_link_align> dut_;
  std::deque<std::uint32_t> words_;
  std::uint64_t clock_ = 0;
  int spoil_ = -1;
  unsigned clock_lane_ = 0;  // the last samples, where nothing spoiled them
  int high_ = 0;             // clocks of the pulse
  int low_ = 4;              // clocks since the last one
  bool loads_now_ = false;
  int pulses_ = 0;
  std::vector<std::uint64_t> load_clocks_;
  int tap_ = 0;      // of the delay
  int shown_ = 0;    // in the samples
  int to_show_ = 0;  // clocks until tap_ is shown
  bool locked_ = false;
  int errors_ = 0;
  int words_given_ = 0;
};

// Any eyes: the middle of the widest one is found in the time that the header names, and every word follows.
TEST(ChannelLinkAlign, TheMiddleOfTheEye) {
  std::array<int, 7> turns{};
  for_cases(200, [&](Random& random, std::uint64_t seed) {
    AlignBench bench(seed);
    bench.eyes = any_eyes(random);
    const int middle = middle_of(bench.eyes);
    int first = 0;  // good tap, from which the search begins again
    while (first < kTaps && bench.eyes[static_cast<std::size_t>(first)].kind != Eye::good) {
      ++first;
    }
    if (middle < 0) {
      EXPECT_FALSE(bench.lock(3 * kSearch));
      return;
    }
    if (!locks(bench.eyes)) {  // loads of a search: the first tap, once more where one is good, and for the chosen tap
      EXPECT_FALSE(bench.lock(4 * kSearch));
      ASSERT_GE(bench.load_clocks().size(), 4U);
      EXPECT_EQ(bench.load_clocks()[3] - bench.load_clocks()[2],
                static_cast<std::uint64_t>(8 * middle + kSettle + kPatience + kToGiveUp));
      return;
    }
    ASSERT_TRUE(bench.lock(kSearch + (first + 1) * kAtATap));
    EXPECT_EQ(bench.tap(), middle);
    EXPECT_EQ(bench.clock_number(),
              static_cast<std::uint64_t>((first + 1 + kTaps) * kAtATap + 8 * (middle + 1) + kToLock));
    EXPECT_EQ(bench.words(), 0);
    const int pulses = bench.pulses();
    bench.clocks(100);
    EXPECT_GE(bench.words(), 98);
    EXPECT_EQ(bench.errors(), 0);
    EXPECT_EQ(bench.pulses(), pulses);
    ++turns[static_cast<std::size_t>(bench.eyes[static_cast<std::size_t>(middle)].turn)];
  });
  if (runs_all_cases()) {
    for (const int times : turns) {
      EXPECT_GT(times, 5);
    }
  }
}

// Any wrong samples of the clock lane with both levels: that word is not given, the lock ends once and comes again
// without a search.
TEST(ChannelLinkAlign, AWrongWordEndsTheLockButNotTheAlignment) {
  for_cases(7, [&](Random& random, std::uint64_t seed) {
    AlignBench bench(seed);
    bench.all({Eye::good, static_cast<int>(seed % 7)});
    ASSERT_TRUE(bench.lock(2 * kSearch));
    bench.clocks(random.between(2, 30));
    int errors = 0;
    for (unsigned samples = 1; samples < 0x7f; ++samples) {
      if (samples == bench.clock_lane()) {
        continue;
      }
      const int pulses = bench.pulses();
      const std::uint64_t from = bench.clock_number();
      const unsigned wrong = samples ^ bench.clock_lane();
      const auto turn = static_cast<unsigned>(seed % 7);
      const bool first = (wrong & ((1U << turn) - 1)) != 0;  // the word that ends in this clock is wrong
      const bool second = wrong >> turn != 0;                // the next one is
      bench.spoil(samples);
      bench.clocks(kLatency + 1);
      EXPECT_EQ(bench.errors(), ++errors);
      EXPECT_FALSE(bench.locked());
      const int words = bench.words();
      ASSERT_TRUE(bench.lock(20 + kRightWords));
      // After two wrong words in a row, the lock waits for 15 clocks.
      EXPECT_EQ(bench.clock_number() - from,
                static_cast<std::uint64_t>(kLatency + kRightWords + (second ? 1 : 0) + (first && second ? 15 : 0)));
      EXPECT_EQ(bench.words(), words);
      bench.clocks(random.between(5, 40));
      EXPECT_EQ(bench.pulses(), pulses);
      EXPECT_GT(bench.words(), words);
    }
  });
}

// Words that stay wrong: the search begins when the patience has ended, not before, and finds the new phase.
TEST(ChannelLinkAlign, SearchesAgainAfterItsPatience) {
  for_cases(30, [&](Random& random, std::uint64_t seed) {
    AlignBench bench(seed);
    bench.eyes = eyes_that_lock(random);
    ASSERT_TRUE(bench.lock(2 * kSearch));
    bench.clocks(random.between(2, 100));
    const Eyes before = bench.eyes;
    const int loads = bench.loads();

    bench.all(Eye::wrong);
    bench.clocks(kLatency + kPatience - 20 - kRightWords - 1);  // just in time
    EXPECT_EQ(bench.errors(), 1);
    bench.eyes = before;
    bench.clocks(kPatience);
    EXPECT_TRUE(bench.locked());
    EXPECT_EQ(bench.loads(), loads);

    bench.all(Eye::wrong);
    const std::uint64_t from = bench.clock_number();
    while (bench.loads() == loads && bench.clock_number() < from + 2 * kPatience) {
      bench.clock();
    }
    // the first sample is the wrong one; not turned, it belongs to the word that ends one clock later
    const int later = bench.eyes[0].turn == 0 ? 1 : 0;
    EXPECT_EQ(bench.clock_number() - from, static_cast<std::uint64_t>(kLatency + kPatience + kToLoad + later));
    bench.eyes = eyes_that_lock(random);
    ASSERT_TRUE(bench.lock(3 * kSearch));
    EXPECT_EQ(bench.tap(), middle_of(bench.eyes));
    EXPECT_EQ(bench.errors(), 2);
  });
}

// A clock lane that stood still, if only for a word: the phase may have changed, so the search begins at once, even if
// the words would be right.
TEST(ChannelLinkAlign, SearchesAgainWhereTheCableWasOut) {
  for_cases(30, [&](Random& random, std::uint64_t seed) {
    AlignBench bench(seed);
    const Eyes before = bench.eyes = eyes_that_lock(random);
    ASSERT_TRUE(bench.lock(2 * kSearch));
    bench.clocks(random.between(2, 100));
    const int loads = bench.loads();
    bench.all(random.chance(50) ? Eye::low : Eye::high);
    bench.clocks(random.chance(50) ? 1 : random.between(2, 3 * kSearch));
    bench.eyes = before;
    bench.clocks(kLatency + 10);
    EXPECT_FALSE(bench.locked());
    EXPECT_EQ(bench.errors(), 1);
    EXPECT_GT(bench.loads(), loads);
    ASSERT_TRUE(bench.lock(3 * kSearch));
    EXPECT_EQ(bench.tap(), middle_of(before));
  });
}

// A cable that comes within the search, or goes for as little as a word and comes in another phase: the taps before do
// not count.
TEST(ChannelLinkAlign, ACableThatComesWithinTheSearch) {
  for_cases(200, [&](Random& random, std::uint64_t seed) {
    AlignBench bench(seed);
    const auto plugged = [&] {
      Eyes eyes;
      eyes.fill({Eye::good, random.between(0, 6)});
      const int edge = random.between(0, 11);
      for (int tap = edge; tap < kTaps; ++tap) {
        Eye& eye = eyes[static_cast<std::size_t>(tap)];
        eye = {tap == edge ? Eye::wrong : Eye::good, (eye.turn + 1) % 7};
      }
      return eyes;
    };
    const bool noise = random.chance(50);
    if (!noise && random.chance(70)) {
      bench.eyes = plugged();
      bench.clocks(random.between(1, kSearch));
    }
    bench.all(noise ? Eye::noise : random.chance(50) ? Eye::low : Eye::high);
    bench.clocks(noise ? random.between(2 * kAtATap, kSearch) : random.chance(50) ? 1 : random.between(2, kSearch));
    bench.eyes = plugged();
    bench.clocks(kLatency + 1);  // a lock ends
    ASSERT_TRUE(bench.lock(3 * kSearch));
    EXPECT_EQ(bench.tap(), middle_of(bench.eyes));
    bench.clocks(20);
    EXPECT_GT(bench.words(), 15);
  });
}

// A reset at any time ends the lock and the pulses, and the search begins.
TEST(ChannelLinkAlign, AResetBeginsAnew) {
  for_cases(40, [&](Random& random, std::uint64_t seed) {
    AlignBench bench(seed);
    bench.eyes = eyes_that_lock(random);
    bench.clocks(random.between(1, 2 * kSearch));
    bench.reset();
    ASSERT_TRUE(bench.lock(3 * kSearch));
    EXPECT_EQ(bench.tap(), middle_of(bench.eyes));
    bench.clocks(10);
    EXPECT_GE(bench.words(), 8);
  });
}

}  // namespace
}  // namespace selfproj::test
