// The Gray-code decoder with its state in an external memory that has latency and stalls: what comes in time is decoded
// as the model does it, what comes too late abandons its frame, is flagged and counted, and nothing wrong ever comes
// out.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>

#include "tests/rtl/blocks/gray_axi_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// A memory without stalls that is fast enough keeps up with a beat in every clock; between frames it needs a pause.
TEST(GrayAxiMemory, KeepsUpWithEveryClock) {
  Random random(1);
  const GraySettings settings{.rows = 16, .columns = 64, .bits = 3, .threshold = 20};
  for (const int latency : {1, 20, 40}) {  // below the depth of the FIFO less a burst
    GrayAxiBench bench(random, settings);
    bench.memory().latency = latency;
    for (int frame = 0; frame < 12; ++frame) {
      bench.idle(3 * latency + 64 + 40);
      bench.frame(random_pixels(random, settings), frame % 6, 0, 1000);
      ASSERT_FALSE(HasFatalFailure());
    }
    bench.idle(20);
    bench.judge();
    EXPECT_EQ(bench.lates, 0U) << "latency " << latency;
    EXPECT_EQ(bench.pixels, 4U * 16U * 64U);
  }
}

// The longest code there is: every bit of a word in the memory is used.
TEST(GrayAxiMemory, EveryBitOfTheState) {
  Random random(2);
  const GraySettings settings{.rows = 4, .columns = 64, .bits = GrayDecoder::kMaxBits, .threshold = 90};
  for (int run = 0; run < 4; ++run) {  // each at another place of the memory
    GrayAxiBench bench(random, settings);
    for (int frame = 0; frame < 4 * settings.bits; ++frame) {
      bench.idle(120);
      bench.frame(random_pixels(random, settings), frame % (2 * settings.bits), 0, 1000);
      ASSERT_FALSE(HasFatalFailure());
    }
    bench.idle(20);
    bench.judge();
    EXPECT_EQ(bench.lates, 0U);
  }
}

TEST(GrayAxiMemory, LatencyAndStalls) {
  GrayAxiCounts counts;
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    play_gray_axi_frames(seed, counts);
    ASSERT_FALSE(HasFailure());
  }
  if (runs_all_cases()) {
    EXPECT_GT(counts.pixels, 50'000U) << "too little was decoded";
    EXPECT_GT(counts.lates, counts.frames / 20) << "too little came too late";
  }
}

}  // namespace
}  // namespace selfproj::test
