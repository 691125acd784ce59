// Soak of the receiver of datagrams: more packets of one session than their numbers have values.
//
//     datagram_soak [PACKETS]      2^33 by default
#include <cstdint>

#include "tests/host/driver/datagram_accounts.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryPacketDeliveredOrCounted) {
  const std::uint64_t packets = soak_command.number(0, std::uint64_t{1} << 33U);
  const driver::Counters counters = expect_all_accounted(0, 0, packets);
  report_soak("datagram_soak",
              "Packets of one session through the receiver of datagrams, of which some are lost, "
              "doubled and overtaken",
              {{"packets", packets},
               {"delivered", packets - counters.lost_network},
               {"lost", counters.lost_network},
               {"doubled", counters.datagrams_doubled},
               {"overtaken", counters.datagrams_reordered}});
}

}  // namespace
}  // namespace selfproj::test
