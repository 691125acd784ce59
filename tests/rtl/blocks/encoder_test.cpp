// Compares the quadrature decoder with a reference that follows the two lines sample by sample.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "Vsp_encoder_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// Position in the cycle 00, 01, 11, 10 of {b, a}.
constexpr int position(int a, int b) { return b != 0 ? (a != 0 ? 2 : 3) : a; }

// Counts the samples of the two lines, one in each clock.
class Reference {
 public:
  // The lines have stood at these levels since before the reset ended.
  Reference(int a, int b) : level_{a, b}, last_{a, b} {}

  // Takes the sample of one clock. The counts include all levels that are stable with this sample.
  void sample(int a, int b) {
    const std::array<int, 2> now = {a, b};
    const int before = position(level_[0], level_[1]);
    for (std::size_t i = 0; i < 2; ++i) {
      same_[i] = now[i] == last_[i] ? same_[i] + 1 : 1;
      last_[i] = now[i];
      if (same_[i] >= 3) {
        level_[i] = now[i];
      }
    }
    switch ((position(level_[0], level_[1]) - before) & 3) {
      case 1:
        ++count;
        break;
      case 2:
        ++errors;
        break;
      case 3:
        --count;
        break;
      default:
        break;
    }
  }

  std::uint32_t count = 0;
  std::uint16_t errors = 0;

 private:
  std::array<int, 2> level_;
  std::array<int, 2> last_;
  std::array<int, 2> same_ = {3, 3};
};

// If edge e samples a change, edge e + 2 takes the third of three equal samples, and count_o contains the change for
// edge e + 7, five clocks after the third sample. Errors show one clock earlier.
constexpr std::size_t kDelay = 5;

class EncoderBench {
 public:
  EncoderBench(int a, int b) : reference_(a, b), history_(kDelay, {0, 0}) {
    encoder_->a_i = static_cast<CData>(a);
    encoder_->b_i = static_cast<CData>(b);
    encoder_.reset();
    for (int i = 0; i < 10; ++i) {
      step(a, b);
    }
  }

  void step(int a, int b) {
    encoder_->a_i = static_cast<CData>(a);
    encoder_->b_i = static_cast<CData>(b);
    encoder_.settle();
    reference_.sample(a, b);
    ASSERT_EQ(encoder_->count_o, history_[next_].count) << "clock " << encoder_.clock();
    ASSERT_EQ(encoder_->errors_o, history_[(next_ + 1) % kDelay].errors) << "clock " << encoder_.clock();
    history_[next_] = {reference_.count, reference_.errors};
    next_ = (next_ + 1) % kDelay;
    encoder_.rise();
  }
  void rest(int a, int b, int clocks) {
    for (int i = 0; i < clocks; ++i) {
      step(a, b);
    }
  }

  std::uint32_t count() { return encoder_->count_o; }
  std::uint16_t errors() { return encoder_->errors_o; }
  const Reference& reference() const { return reference_; }

 private:
  struct Counts {
    std::uint32_t count;
    std::uint16_t errors;
  };
  Clocked<Vsp_encoder> encoder_;
  Reference reference_;
  std::vector<Counts> history_;
  std::size_t next_ = 0;
};

constexpr std::array<std::array<int, 2>, 4> kCycle = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};  // {a, b}, a leads

TEST(Encoder, CountsUpWhereALeadsAndDownWhereBLeads) {
  EncoderBench bench(0, 0);
  for (int i = 1; i <= 40; ++i) {
    const auto& lines = kCycle[static_cast<std::size_t>(i % 4)];
    bench.rest(lines[0], lines[1], 12);
    ASSERT_EQ(bench.count(), static_cast<std::uint32_t>(i));
  }
  for (int i = 39; i >= -40; --i) {
    const auto& lines = kCycle[static_cast<std::size_t>(i & 3)];
    bench.rest(lines[0], lines[1], 12);
    ASSERT_EQ(bench.count(), static_cast<std::uint32_t>(i));
  }
  EXPECT_EQ(bench.errors(), 0);
}

// Steps through every value of the lower chain, up and down, as fast as steps can be counted.
TEST(Encoder, CountsFarUpAndFarDown) {
  EncoderBench bench(0, 0);
  int at = 0;
  for (const int end : {66'000, -66'000, 300}) {
    while (at != end) {
      at += at < end ? 1 : -1;
      const auto& lines = kCycle[static_cast<std::size_t>(at & 3)];
      bench.rest(lines[0], lines[1], 3);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    bench.rest(kCycle[static_cast<std::size_t>(at & 3)][0], kCycle[static_cast<std::size_t>(at & 3)][1], 12);
    ASSERT_EQ(bench.count(), static_cast<std::uint32_t>(end));
  }
  EXPECT_EQ(bench.errors(), 0);
}

// A change sampled by edge e is in count_o for edge e + 7, and not earlier.
TEST(Encoder, LatencyIsSevenClocks) {
  Clocked<Vsp_encoder> encoder;
  encoder->a_i = 0;
  encoder->b_i = 0;
  encoder.reset();
  for (int i = 0; i < 20; ++i) {
    encoder.tick();
  }
  encoder->a_i = 1;
  for (int clock = 0; clock <= 7; ++clock) {  // edge e ends clock 0
    encoder.settle();
    ASSERT_EQ(encoder->count_o, clock < 7 ? 0U : 1U) << "clock " << clock;
    encoder.rise();
  }
}

TEST(Encoder, LevelsAtResetAreTakenOverWithoutCounting) {
  for (const auto& lines : kCycle) {
    EncoderBench bench(lines[0], lines[1]);
    bench.rest(lines[0], lines[1], 30);
    EXPECT_EQ(bench.count(), 0U);
    EXPECT_EQ(bench.errors(), 0U);
  }
}

TEST(Encoder, PulsesOfOneAndTwoClocksAreSuppressedOneOfThreeCounts) {
  for (int line = 0; line < 2; ++line) {
    EncoderBench bench(0, 0);
    std::vector<std::uint32_t> seen;
    for (int width = 1; width <= 3; ++width) {
      bench.rest(line == 0, line == 1, width);
      for (int i = 0; i < 12; ++i) {
        bench.step(0, 0);
        seen.push_back(bench.count());
      }
      const bool moved = std::any_of(seen.begin(), seen.end(), [](std::uint32_t count) { return count != 0; });
      EXPECT_EQ(moved, width == 3) << "width " << width;
      EXPECT_EQ(bench.count(), 0U);
    }
    EXPECT_EQ(bench.errors(), 0U);
  }
}

TEST(Encoder, AStepOfBothLinesIsAnErrorAndNoStep) {
  EncoderBench bench(0, 0);
  for (int i = 1; i <= 10; ++i) {
    bench.rest(i % 2, i % 2, 12);
    EXPECT_EQ(bench.count(), 0U);
    EXPECT_EQ(bench.errors(), i);
  }
}

TEST(Encoder, RandomWalksWithPulsesAndErrors) {
  for_cases(100, [&](Random& random) {
    int at = random.between(0, 3);
    EncoderBench bench(kCycle[static_cast<std::size_t>(at)][0], kCycle[static_cast<std::size_t>(at)][1]);
    const int fastest = random.between(1, 6);
    const int pulses = random.between(0, 20);
    for (int i = 0; i < 400; ++i) {
      at = (at + (random.chance(60) ? 1 : random.chance(90) ? 3 : 2)) & 3;
      const auto& lines = kCycle[static_cast<std::size_t>(at)];
      for (int clocks = random.between(fastest, fastest + 5); clocks > 0; --clocks) {
        bench.step(lines[0] ^ (random.chance(pulses) ? 1 : 0), lines[1] ^ (random.chance(pulses) ? 1 : 0));
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
    }
    EXPECT_NE(bench.reference().count, 0U);
  });
}

// Both counters wrap: a few more than 65,536 errors, and a count below zero.
TEST(Encoder, CountsWrap) {
  EncoderBench bench(0, 0);
  for (int i = 1; i <= 65540; ++i) {
    bench.rest(i % 2, i % 2, 3);
    ASSERT_FALSE(::testing::Test::HasFatalFailure());
  }
  bench.rest(0, 0, 12);
  EXPECT_EQ(bench.errors(), 4);
  bench.rest(0, 1, 12);
  EXPECT_EQ(bench.count(), 0xFFFF'FFFFU);
}

}  // namespace
}  // namespace selfproj::test
