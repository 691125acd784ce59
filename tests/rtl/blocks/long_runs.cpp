// Tests counts after days: they start near a carry and near their end, which they pass. (Not for netlists, because
// their registers have other names.)
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>

#include "Vsp_counter32_ports.h"
#include "Vsp_counter64_ports.h"
#include "Vsp_gray_match_small_ports.h"
#include "model/datagram.h"
#include "tests/rtl/blocks/datagram_cutter_bench.h"
#include "tests/rtl/blocks/gray_match_bench.h"
#include "tests/rtl/blocks/link_bench.h"
#include "tests/rtl/inner_register.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The numbers of datagrams and packets of a session
TEST(DatagramCutter, NumbersCarryAndWrapInALongSession) {
  Random random(1);
  for (const std::uint32_t place : {0U, 0x8000'0000U, 0x0100'0000U, 0x5A5A'0000U}) {
    SCOPED_TRACE(place);
    CutterBench<Vsp_datagram_cutter_small> bench(kSmallBytes);
    bench.begin_session(static_cast<std::uint16_t>(random.bits()));
    bench.clock(0, 100);
    bench.go_on_after(place - 20, place - 6);
    Verilated::threadContextp(bench->contextp());
    InnerRegister("TOP.sp_datagram_cutter.sequence_q").set(place - 20);
    InnerRegister("TOP.sp_datagram_cutter.packet_q").set(place - 6);
    bench.clock(0, 100);
    for (int packet = 0; packet < 12; ++packet) {
      bench.queue(random_packet(random, 14));
    }
    bench.drain();
    for (int i = 0; i < 10 * kSmallIdle; ++i) {
      bench.clock(0, 100);
    }
    ASSERT_FALSE(HasFailure());
    const std::optional<model::DatagramHeader> last = model::read_datagram_header(bench.datagrams().back());
    ASSERT_TRUE(last);
    EXPECT_EQ(last->packet, place + 6);
    EXPECT_LT(last->sequence - place, 60U) << "beyond the carry";
  }
}

// Every chain of a counter waits for all chains below it: each is full, all but full, or anything else.
template <typename Dut>
void carry_past_chains(const char* chains_of, int low_bits, int chain_bits, int chains) {
  Random random(1);
  const std::uint64_t ones = (std::uint64_t{1} << chain_bits) - 1;
  for (int state = 0; state < static_cast<int>(std::pow(3, chains)); ++state) {
    std::uint64_t upper = 0;
    for (int k = 0, rest = state; k < chains; ++k, rest /= 3) {
      const std::uint64_t chain = rest % 3 == 0 ? ones : rest % 3 == 1 ? ones - 1 : random.bits() % ones;
      upper |= chain << (chain_bits * k);
    }
    Clocked<Dut> counter;
    counter->inc_i = 0;
    counter.reset();
    Verilated::threadContextp(counter->contextp());
    InnerRegister(chains_of).set(upper);
    std::uint64_t count = upper << low_bits;
    const auto run = [&](int clocks, int percent) {
      for (int i = 0; i < clocks; ++i) {
        counter->inc_i = random.chance(percent);
        const bool counts = counter->inc_i != 0;
        counter.tick();
        count += counts ? 1 : 0;
      }
    };
    run(600, random.between(50, 100));
    run(2, 0);  // until the last one shows
    counter.settle();
    const int unused = 64 - low_bits - chain_bits * chains;
    ASSERT_EQ(static_cast<std::uint64_t>(counter->count_o) << unused, count << unused) << "chains " << state;
  }
}
TEST(Counter, EveryChainWaitsForAllBelowIt) {
  carry_past_chains<Vsp_counter32>("TOP.sp_counter.upper_q", 8, 12, 2);
  carry_past_chains<Vsp_counter64>("TOP.sp_counter.upper_q", 8, 14, 4);
}

// The ticket of the mailbox
TEST(Link, TicketsWrap) {
  for (const std::uint32_t place : {0U, 0x8000'0000U, 0x0001'0000U}) {
    SCOPED_TRACE(place);
    Random random(place + 1);
    LinkBench bench(place + 1);
    LinkModel model(place - 8);
    Verilated::threadContextp(bench->contextp());
    InnerRegister("TOP.sp_link.u_registers.ticket_q").set(place - 8);
    LinkFigures figures;
    expect_link_equals_model(bench, model, random, 60, figures);
    ASSERT_FALSE(HasFailure());
    EXPECT_GT(figures.answers, 15U);
  }
}

// The matching block's count of late words carries through every bit.
TEST(GrayMatchSmall, LateWordsAreCountedIn32Bits) {
  constexpr GrayMatchBuild kBuild = {6, 2, 5};
  for (int bit = 8; bit <= 32; ++bit) {
    Random random(static_cast<std::uint64_t>(bit));
    GrayMatchBench<Vsp_gray_match_small> bench(random, kBuild);
    bench.lates_before = static_cast<std::uint32_t>((std::uint64_t{1} << bit) - 2);
    bench.dut().late_o = bench.lates_before;  // the port is the register
    bench.late_permille = 300;
    play_match_frames(bench, kBuild, 20, random);
    EXPECT_GT(bench.lates(), 2U);
    ASSERT_FALSE(HasFailure());
  }
}

}  // namespace
}  // namespace selfproj::test
