// Tests the cutter of packets into datagrams after days: its numbers start near a carry and near their end. (Not for
// netlists, because their registers have other names.)
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>

#include "model/datagram.h"
#include "tests/rtl/blocks/datagram_cutter_bench.h"
#include "tests/rtl/inner_register.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

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
    const std::optional<DatagramHeader> last = read_datagram_header(bench.datagrams().back());
    ASSERT_TRUE(last);
    EXPECT_EQ(last->packet, place + 6);
    EXPECT_LT(last->sequence - place, 60U) << "beyond the carry";
  }
}

}  // namespace
}  // namespace selfproj::test
