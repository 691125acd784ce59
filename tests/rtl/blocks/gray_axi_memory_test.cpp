// Tests the Gray-code decoder with its state in an external memory that has latency and stalls. Frames whose words come
// in time are decoded like in the model. A word that comes too late abandons its frame, which is flagged and counted.
// No wrong code ever comes out.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "tests/rtl/blocks/axi_memory_model.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/gray_axi_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// A fast enough memory without stalls keeps up with a beat in every clock, but needs a pause between frames.
TEST(GrayAxiMemory, KeepsUpWithEveryClock) {
  Random random(1);
  const model::GraySettings settings{.rows = 16, .columns = 64, .bits = 3, .threshold = 20};
  for (const int latency : {1, 20, 40}) {  // below the depth of the FIFO minus a burst
    GrayAxiBench bench(random, settings);
    bench.memory().latency = latency;
    for (int frame = 0; frame < 12; ++frame) {
      bench.idle(3 * latency + 64 + 40);
      bench.frame(random_pixels(random, settings), frame % 6, 0, 1000);
      ASSERT_FALSE(HasFatalFailure());
    }
    bench.idle(20);
    bench.compare();
    EXPECT_EQ(bench.lates, 0U) << "latency " << latency;
    EXPECT_EQ(bench.pixels, 4U * 16U * 64U);
  }
}

// The longest code uses every bit of a word in the memory.
TEST(GrayAxiMemory, EveryBitOfTheState) {
  Random random(2);
  const model::GraySettings settings{.rows = 4, .columns = 64, .bits = model::GrayDecoder::kMaxBits, .threshold = 90};
  for (int run = 0; run < 4; ++run) {  // each at a different place in the memory
    GrayAxiBench bench(random, settings);
    for (int frame = 0; frame < 4 * settings.bits; ++frame) {
      bench.idle(120);
      bench.frame(random_pixels(random, settings), frame % (2 * settings.bits), 0, 1000);
      ASSERT_FALSE(HasFatalFailure());
    }
    bench.idle(20);
    bench.compare();
    EXPECT_EQ(bench.lates, 0U);
  }
}

TEST(GrayAxiMemory, LatencyAndStalls) {
  GrayAxiCounts counts;
  for_cases(60, [&](std::uint64_t seed) { play_gray_axi_frames(seed, counts); });
  if (runs_all_cases()) {
    EXPECT_GT(counts.pixels, 50'000U) << "too little was decoded";
    EXPECT_GT(counts.lates, counts.frames / 20) << "too little came too late";
  }
}

// Tests the port alone, with frames larger than those of the decoder. Every clock requests a word; a changed word is
// written back five clocks later.
class WordsBench {
 public:
  explicit WordsBench(Random& random) : random_(random), memory_(random, kMemoryWords) {
    memory_.base = 0xABCD'EF00;
    memory_.at_rest(port_.dut());
    port_.reset();
  }

  AxiMemory& memory() { return memory_; }

  // The number of words of the frame that came in time, counted from the first.
  std::size_t frame(std::size_t words) {
    stored_.resize(std::max(stored_.size(), words));
    std::size_t in_time = 0;
    bool lost = false;
    std::vector<Word128> given;
    for (std::size_t i = 0; i < words + kWriteDelay; ++i) {
      port_->rd_en_i = i < words;
      port_->rd_first_i = i == 0;
      port_->wr_en_i = i >= kWriteDelay;
      given.push_back({static_cast<std::uint32_t>(random_.bits()), static_cast<std::uint32_t>(random_.bits()),
                       static_cast<std::uint32_t>(random_.bits()), static_cast<std::uint32_t>(random_.bits())});
      set128(port_->wr_data_i, i >= kWriteDelay ? given[i - kWriteDelay] : given[i]);
      port_->end_i = i + 1 == words + kWriteDelay;
      memory_.drive(port_.dut(), port_.clock());
      port_.settle();
      if (i >= 2 && i < words + 2) {
        const std::size_t word = i - 2;
        if (port_->rd_late_o != 0) {
          lost = true;
        } else {
          EXPECT_FALSE(lost) << "a word of a frame whose words came too late";
          if (known_ > word) {
            EXPECT_EQ(word128(port_->rd_data_o), stored_[word]) << "word " << word;
          }
          ++in_time;
        }
      }
      edge();
    }
    port_->wr_en_i = 0;
    port_->end_i = 0;
    for (std::size_t i = 0; i < in_time; ++i) {
      stored_[i] = given[i];
    }
    known_ = std::max(known_, in_time);
    return in_time;
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks && !::testing::Test::HasFatalFailure(); ++i) {
      memory_.drive(port_.dut(), port_.clock());
      port_.settle();
      edge();
    }
  }

 private:
  static constexpr std::size_t kWriteDelay = 5;

  void edge() {
    memory_.edge(port_.dut(), port_.clock());
    port_.rise();
  }

  Random& random_;
  Clocked<Vsp_gray_axi_memory> port_;
  AxiMemory memory_;
  std::vector<Word128> stored_;  // what the frames wrote
  std::size_t known_ = 0;        // words of it, from the first on
};

// The words of the next frame are read only when all bursts of this one are answered. A frame with more open bursts
// than the counter holds (127) is given up.
TEST(GrayAxiMemory, AnswersThatTakeLong) {
  Random random(3);
  WordsBench bench(random);
  bench.memory().answer_latency = 3000;
  for (const std::size_t words : {100U, 1900U, 2500U, 1900U, 2030U}) {
    bench.idle(6500);
    const std::size_t in_time = bench.frame(words);
    EXPECT_GE(in_time, std::min<std::size_t>(words, 127 * 16));
    EXPECT_LT(in_time, 128 * 16 + 64);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_EQ(bench.memory().max_unanswered, 127U);
}

// The memory takes few write addresses, so the write FIFO fills up and the frame is given up.
TEST(GrayAxiMemory, WritesThatAreRefused) {
  Random random(4);
  WordsBench bench(random);
  bench.memory().write_pause = 400;
  bench.idle(100);
  for (const std::size_t words : {40U, 250U, 61U, 100U}) {
    const std::size_t in_time = bench.frame(words);
    EXPECT_LE(in_time, 120U);
    EXPECT_GE(in_time, std::min<std::size_t>(words, 50));
    bench.idle(4000);
    ASSERT_FALSE(HasFailure());
  }
}

}  // namespace
}  // namespace selfproj::test
