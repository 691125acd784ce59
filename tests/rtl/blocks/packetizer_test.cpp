// Tests the packetizer: packets equal those of model/packet byte by byte, decisions and beats come in the clocks that
// its header states, and every dropped packet is counted.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <type_traits>

#include "tests/rtl/blocks/packetizer_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::packetizer {
namespace {

template <typename Dut>
class Packetizer : public ::testing::Test {};
using Kinds = ::testing::Types<Vsp_packetizer, Vsp_packetizer_image>;
struct KindNames {
  template <typename Dut>
  static std::string GetName(int) {  // NOLINT(readability-identifier-naming): GoogleTest's name
    return std::is_same_v<Dut, Vsp_packetizer> ? "Moments" : "Image";
  }
};
TYPED_TEST_SUITE(Packetizer, Kinds, KindNames);

// Each packet is requested as soon as the previous one is done: all are delivered.
TYPED_TEST(Packetizer, AStartSevenClocksAfterTheLastPayloadIsTaken) {
  Random random(1);
  for (int early = -1; early < 2; ++early) {
    PacketizerBench<TypeParam> bench(random);
    for (int i = 0; i < 200; ++i) {
      // decided two clocks after the start, in the first clock in which the packetizer is idle
      while (bench.idle_from() == INT64_MAX || bench.now() + 2 < bench.idle_from()) {
        bench.clock({});
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
      bench.clock({.start = true, .payload_beats = random.between(1, 20), .line = random.between(1, 1023)},
                  {early, 0, early >= 0, 1});
      for (int k = 0; k < 3; ++k) {
        bench.clock({});
      }
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    bench.finish();
    EXPECT_EQ(bench.delivered(), 200);
  }
}

// One clock earlier it is dropped and counted.
TYPED_TEST(Packetizer, AStartSixClocksAfterTheLastPayloadIsLost) {
  Random random(1);
  PacketizerBench<TypeParam> bench(random);
  bench.clock({.start = true, .payload_beats = 3});
  for (int k = 0; k < 3; ++k) {
    bench.clock({});
  }
  while (bench.idle_from() == INT64_MAX || bench.now() + 3 < bench.idle_from()) {
    bench.clock({});
  }
  bench.clock({.start = true, .payload_beats = 3});
  bench.finish();
  EXPECT_EQ(bench.delivered(), 1);
  EXPECT_EQ(bench.lost(), 1U);
}

// Lengths with a single bit set, and the longest that the FIFO holds: complete, and cut short after one beat.
TYPED_TEST(Packetizer, LongPayloads) {
  Random random(1);
  constexpr int kDepth = PacketizerBench<TypeParam>::kFifoDepth;
  for (int early : {-1, 1}) {
    PacketizerBench<TypeParam> bench(random);
    bench.places = kDepth;
    int packets = 0;
    const auto packet = [&](int beats) {
      bench.clock({.start = true, .payload_beats = beats, .line = random.between(1, 1023)}, {early, 0, early >= 0, 1});
      const std::int64_t decided = bench.now() + 3;
      while (bench.now() < decided || bench.idle_from() == INT64_MAX || bench.now() < bench.idle_from() + kDepth) {
        bench.clock({});  // until the FIFO is empty again
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
      EXPECT_EQ(bench.delivered(), ++packets) << beats << " beats";
    };
    for (int beats = 2; beats < kDepth; beats *= 2) {
      packet(beats);
    }
    packet(kDepth - kOverhead);
    bench.clock({.start = true, .payload_beats = kDepth - kOverhead + 1});
    bench.finish();
    EXPECT_EQ(bench.delivered(), packets);
    EXPECT_EQ(bench.lost(), 1U);
    // free places with a single bit set, and a packet that needs one place more
    std::uint32_t lost = 1;
    for (int places = 8; places < kDepth; places *= 2) {
      bench.places = places;
      bench.clock({.start = true, .payload_beats = places - kOverhead + 1});
      bench.finish();
      EXPECT_EQ(bench.delivered(), packets);
      EXPECT_EQ(bench.lost(), ++lost) << places << " places";
      packet(places - kOverhead);
    }
  }
}

// Enough losses to use more than one chain of the counter. Each shows five clocks after its request.
TYPED_TEST(Packetizer, ManyLossesAreCounted) {
  Clocked<TypeParam> packetizer;
  packetizer->break_i = 0;
  packetizer->break_later_i = 0;
  packetizer->spoiled_i = 0;
  packetizer->payload_valid_i = 0;
  packetizer->payload_break_i = 0;
  packetizer->payload_beats_i = 1;
  packetizer->fifo_free_i = 0;
  packetizer->start_i = 0;
  packetizer.reset();
  packetizer->start_i = 1;
  for (std::uint32_t clock = 0; clock < 200'000; ++clock) {
    packetizer.settle();
    if (packetizer->lost_o != (clock < 5 ? 0 : clock - 4) || packetizer->fifo_valid_o || packetizer->accept_o) {
      FAIL() << packetizer->lost_o << " lost, clock " << clock;
    }
    packetizer.rise();
  }
}

// The header after losses of powers of two, and one less.
TYPED_TEST(Packetizer, HeadersTellManyLosses) {
  Random random(1);
  PacketizerBench<TypeParam> bench(random);
  int packets = 0;
  const auto quiet = [&](int clocks) {
    for (int i = 0; i < clocks; ++i) {
      bench.clock({});
    }
  };
  for (std::uint32_t power = 2; power <= 0x10000; power *= 2) {
    for (const std::uint32_t losses : {power - 1, power}) {
      bench.places = 0;
      while (bench.asked() - bench.delivered() < static_cast<int>(losses)) {
        bench.clock({.start = true, .payload_beats = 1});
        quiet(bench.lost() + 8 > losses ? 3 : 0);
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
      bench.places = 32;
      quiet(3);
      bench.clock({.start = true, .payload_beats = 1});
      quiet(40);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
      EXPECT_EQ(bench.delivered(), ++packets);
      EXPECT_EQ(bench.lost(), losses);
    }
  }
}

// Requests at any time, a FIFO that is often full, payloads with gaps and early ends.
TYPED_TEST(Packetizer, RandomRequests) {
  for (const std::uint64_t seed : seeds(80)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    PacketizerBench<TypeParam> bench(random);
    const int often = random.between(1, 25);
    const int gaps = random.chance(50) ? 0 : random.between(1, 80);
    const bool breaks = random.chance(70);
    int quiet = 0;  // clocks without a request
    for (int i = 0; i < 3000; ++i) {
      if (random.chance(1)) {
        bench.drain = random.chance(50) ? 100 : random.between(0, 60);
      }
      bench.spoil_next = random.chance(3);
      typename PacketizerBench<TypeParam>::Request request;
      typename PacketizerBench<TypeParam>::Plan plan;
      request.payload_beats =
          random.between(1, random.chance(80)                      ? 12
                            : random.chance(80)                    ? 40
                            : PacketizerBench<TypeParam>::kPerLine ? 255
                                                                   : 2047);  // some larger than the FIFO
      request.line = random.between(1, 1023);
      request.break_status = static_cast<std::uint32_t>(1 << random.between(0, 4));
      // a frame breaks before the next one asks for anything
      quiet -= quiet > 0 ? 1 : 0;
      request.start = quiet == 0 && random.chance(often);
      request.break_first = breaks && quiet == 0 && !request.start && random.chance(often);
      request.start_status =
          request.start && random.chance(30) ? static_cast<std::uint32_t>(1 << random.between(0, 4)) : 0;
      request.break_with_start = request.start && breaks && random.chance(20);
      if (request.start) {
        plan.gaps = gaps;
        plan.marked = breaks && random.chance(30);
        quiet = plan.marked ? 4 : 0;
        plan.status = static_cast<std::uint32_t>(1 << random.between(0, 4));
        plan.early = plan.marked && random.chance(80) ? random.between(0, request.payload_beats) : -1;
      }
      bench.clock(request, plan);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    bench.drain = 100;
    bench.spoil_next = false;
    bench.finish();
    EXPECT_EQ(static_cast<std::uint32_t>(bench.asked() - bench.delivered()), bench.lost());
    EXPECT_GT(bench.delivered(), 5);
  }
}

}  // namespace
}  // namespace selfproj::test::packetizer
