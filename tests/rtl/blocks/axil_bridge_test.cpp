// Tests the AXI4-Lite bridge: it answers every access once and correctly, with any two clocks and any delays. It times
// out and recovers when the video clock stops, and is fair to both kinds of access.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <vector>

#include "tests/rtl/blocks/axil_bridge_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::axil_bridge {
namespace {

// Writes and reads at the same time. A read may return any value that its register had while the read was under way.
// Therefore each address is written once in one phase and read in the next.
TEST(AxilBridge, EveryAccessIsAnsweredRight) {
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    // nearly equal clocks: no access times out
    AxilBridgeBench bench(random, {1000, 900 + random.between(0, 700), random.between(0, 900)});
    bench.registers_answer_at_once = true;
    std::map<std::uint8_t, std::uint32_t> reference;
    for (int phase = 0; phase < 8; ++phase) {
      constexpr std::array<int, 4> kPercent = {100, 50, 20, 5};
      bench.eager_request = kPercent[static_cast<std::size_t>(random.between(0, 3))];
      bench.eager_answer = kPercent[static_cast<std::size_t>(random.between(0, 3))];
      // even addresses are written, odd ones (written in the phase before) read
      std::vector<Answer> write_answers, read_answers;
      for (int i = random.between(0, 12); i > 0; --i) {
        const Access access = {true, static_cast<std::uint8_t>(random.bits() << 1 | (phase & 1U)),
                               static_cast<std::uint32_t>(random.bits()),
                               static_cast<std::uint8_t>(random.chance(80) ? 15 : random.between(0, 14))};
        bench.ask(access);
        const bool good = access.strobe == 15 && !refused(access.address);
        write_answers.push_back({good ? kOkay : kSlaveError, 0});
        if (good) {
          reference[access.address] = access.data;
        }
      }
      for (int i = random.between(0, 12); i > 0; --i) {
        const auto address = static_cast<std::uint8_t>(random.bits() << 1 | (~phase & 1U));
        bench.ask({false, address, 0, 0});
        read_answers.push_back({refused(address) ? kSlaveError : kOkay, reference[address]});
      }
      bench.write_answers.clear();
      bench.read_answers.clear();
      ASSERT_TRUE(bench.finish(200000)) << "an access has no answer";
      ASSERT_EQ(bench.write_answers.size(), write_answers.size());
      ASSERT_EQ(bench.read_answers.size(), read_answers.size());
      for (std::size_t i = 0; i < write_answers.size(); ++i) {
        ASSERT_EQ(bench.write_answers[i].response, write_answers[i].response) << "write " << i;
      }
      for (std::size_t i = 0; i < read_answers.size(); ++i) {
        ASSERT_EQ(bench.read_answers[i].response, read_answers[i].response) << "read " << i;
        if (read_answers[i].response == kOkay) {
          ASSERT_EQ(bench.read_answers[i].data, read_answers[i].data) << "read " << i;
        }
      }
      ASSERT_FALSE(::testing::Test::HasFailure());
    }
    for (const auto& [address, value] : reference) {
      ASSERT_EQ(bench.registers[address], value);
    }
  }
}

// With any two clocks every access is answered. If the video clock is fast enough for no time-out, every answer is
// right.
TEST(AxilBridge, AnyTwoClocks) {
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    TwoClocks clocks = random_clocks(random);
    SCOPED_TRACE(clocks.describe());
    AxilBridgeBench bench(random, clocks);
    bench.eager_request = random.between(5, 100);
    bench.eager_answer = random.between(5, 100);
    for (int i = 0; i < 40; ++i) {
      bench.ask(
          {random.chance(50), static_cast<std::uint8_t>(random.bits()), static_cast<std::uint32_t>(random.bits()), 15});
    }
    ASSERT_TRUE(bench.finish(400000)) << "an access has no answer";
    ASSERT_EQ(bench.write_answers.size() + bench.read_answers.size(), 40U);
    EXPECT_FALSE(::testing::Test::HasFailure());
  }
}

TEST(AxilBridge, ReadsAndWritesTakeTurns) {
  Random random(1);
  AxilBridgeBench bench(random, {1000, 1100, 300});
  bench.registers_answer_at_once = true;
  for (int i = 0; i < 20; ++i) {
    bench.ask({true, static_cast<std::uint8_t>(i), 0, 15});
    bench.ask({false, static_cast<std::uint8_t>(i), 0, 15});
  }
  ASSERT_TRUE(bench.finish(20000));
  ASSERT_EQ(bench.order.size(), 40U);
  for (std::size_t i = 1; i < bench.order.size(); ++i) {
    EXPECT_NE(bench.order[i], bench.order[i - 1]) << "two of a kind in a row, number " << i;
  }
}

// If a write and a read come in the same clock, the kind that did not come last goes first.
TEST(AxilBridge, TheOtherKindThanTheLastGoesFirst) {
  Random random(1);
  AxilBridgeBench bench(random, {1000, 1100, 300});
  bench.registers_answer_at_once = true;
  for (const bool last : {true, false, false, true, true, false}) {
    bench.ask({last, 4, 1, 15});
    ASSERT_TRUE(bench.finish(2000));
    bench.ask({true, 8, 2, 15});
    bench.ask({false, 8, 0, 15});
    ASSERT_TRUE(bench.finish(2000));
    ASSERT_EQ(bench.order.size() % 3, 0U);
    EXPECT_EQ(bench.order[bench.order.size() - 3], last);
    EXPECT_NE(bench.order[bench.order.size() - 2], last) << "two of a kind in a row";
  }
  EXPECT_FALSE(::testing::Test::HasFailure());
}

// The camera is off: the first access gets SLVERR after 2^TimeoutBits bus clocks, further ones immediately. When the
// clock is back, the late answer is discarded and the next access is right.
TEST(AxilBridge, TimesOutWhileTheVideoClockStandsAndRecovers) {
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    AxilBridgeBench bench(random, {1000, 900 + random.between(0, 300), random.between(0, 900)});
    bench.registers_answer_at_once = true;
    bench.ask({true, 0x10, 0x1111'1111, 15});
    bench.ask({true, 0x14, 0x2222'2222, 15});
    ASSERT_TRUE(bench.finish(2000));
    ASSERT_EQ(bench.write_answers.back().response, kOkay);

    for (int i = random.between(0, 20); i > 0; --i) {
      bench.step();
    }
    bench.video_stopped = true;
    const bool write = random.chance(50);
    bench.ask({write, 0x10, 0x3333'3333, 15});
    ASSERT_TRUE(bench.finish(2000));
    const Answer late = write ? bench.write_answers.back() : bench.read_answers.back();
    EXPECT_EQ(late.response, kSlaveError);
    // the access is taken in the last clock counted; it starts a clock later, and its answer shows two clocks after the
    // last
    const std::int64_t waited = bench.last_answer_clock - bench.last_taken_clock;
    EXPECT_GE(waited, kTimeout);
    EXPECT_LE(waited, kTimeout + 4);

    // immediately from now on
    for (int i = 0; i < 6; ++i) {
      const bool next_write = random.chance(50);
      bench.ask({next_write, 0x14, 0x4444'4444, 15});
      ASSERT_TRUE(bench.finish(2000));
      EXPECT_EQ((next_write ? bench.write_answers : bench.read_answers).back().response, kSlaveError);
      EXPECT_LE(bench.last_answer_clock - bench.last_taken_clock, 3);
    }

    bench.video_stopped = false;
    const std::size_t answers = bench.write_answers.size() + bench.read_answers.size();
    for (int i = 0; i < 100; ++i) {
      bench.step();
    }
    EXPECT_EQ(bench.write_answers.size() + bench.read_answers.size(), answers) << "the late answer went to somebody";
    bench.ask({false, 0x14, 0, 15});
    ASSERT_TRUE(bench.finish(2000));
    EXPECT_EQ(bench.read_answers.back().response, kOkay);
    EXPECT_EQ(bench.read_answers.back().data, 0x2222'2222U) << "a refused write has written";
    bench.ask({true, 0x18, 0x5555'5555, 15});
    ASSERT_TRUE(bench.finish(2000));
    EXPECT_EQ(bench.write_answers.back().response, kOkay);
    EXPECT_EQ(bench.registers[0x18], 0x5555'5555U);
    EXPECT_FALSE(::testing::Test::HasFailure());
  }
}

// The video clock comes back while accesses go on: each is answered, and the registers see each request at most once.
TEST(AxilBridge, AccessesGoOnWhileTheVideoClockStopsAndStarts) {
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    AxilBridgeBench bench(random, random_clocks(random));
    bench.eager_request = random.between(20, 100);
    bench.eager_answer = random.between(20, 100);
    std::uint32_t number = 0;
    for (int i = 0; i < 40; ++i) {
      bench.video_stopped = random.chance(50);
      for (int k = 0; k < 3; ++k) {
        bench.ask({random.chance(50), static_cast<std::uint8_t>(4 * random.between(0, 20)), ++number, 15});
      }
      for (int k = random.between(0, 300); k > 0; --k) {
        bench.step();
      }
    }
    ASSERT_TRUE(bench.finish(400000)) << "an access has no answer";
    EXPECT_EQ(bench.write_answers.size() + bench.read_answers.size(), 120U);
    std::uint32_t last = 0;
    for (const Access& access : bench.requested) {
      if (access.write) {
        EXPECT_GT(access.data, last) << "a write came twice or out of order";
        last = access.data;
      }
    }
    EXPECT_FALSE(::testing::Test::HasFailure());
  }
}

}  // namespace
}  // namespace selfproj::test::axil_bridge
