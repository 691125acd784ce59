// Tests the wire between the simulated FPGA and the host: RGMII, and a network with faults.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/target/faulty_network.h"
#include "sim/target/rgmii.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The check of the digits 1 to 9, as textbooks have it.
TEST(Rgmii, CheckIsCrc32) {
  constexpr std::array<std::uint8_t, 9> kDigits = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(ethernet_check(kDigits), 0xCBF4'3926U);
}

// Frames of any length come as they were sent, short ones filled up; damaged ones do not come.
TEST(Rgmii, FramesComeAsTheyWereSent) {
  Random random(1);
  RgmiiSender sender;
  RgmiiReceiver receiver;
  std::vector<EthernetFrame> due;
  std::uint64_t damaged = 0;
  for (int i = 0; i < 40; ++i) {
    EthernetFrame frame = random.bytes(static_cast<std::size_t>(random.between(14, i % 2 == 0 ? 70 : 1514)));
    const bool damage = random.chance(30);
    sender.send(frame, damage);
    frame.resize(frame.size() < 60 ? 60 : frame.size());
    damaged += damage ? 1 : 0;
    if (!damage) {
      due.push_back(frame);
    }
  }
  std::vector<EthernetFrame> came;
  for (int clock = 0; clock < 100000; ++clock) {
    const RgmiiSender::Pins low = sender.rising();
    receiver.rising(low.control, low.data);
    if (std::optional<EthernetFrame> frame = receiver.falling(sender.falling().data)) {
      came.push_back(*frame);
    }
  }
  EXPECT_EQ(came, due);
  EXPECT_EQ(receiver.damaged(), damaged);
  EXPECT_GT(damaged, 3U);
}

// Only datagrams of the port are hit. What came, less the dropped, plus the doubled, is what arrives.
TEST(FaultyNetwork, CountsWhatItDoes) {
  EthernetFrame datagram(60);
  datagram[12] = 8;
  datagram[14] = 0x45;
  datagram[23] = 17;
  datagram[34] = 1235 >> 8;
  datagram[35] = 1235 & 255;
  EthernetFrame other = datagram;
  other[35] ^= 1;
  FaultyNetwork network(1235, {.dropped = 10, .doubled = 10, .reordered = 10}, 1);
  std::size_t arrived = 0;
  constexpr std::size_t kSent = 2000;
  for (std::size_t i = 0; i < kSent; ++i) {
    arrived += network.pass(datagram).size();
    EXPECT_EQ(network.pass(other).size(), 1U);
  }
  arrived += network.flush() ? 1 : 0;
  EXPECT_FALSE(network.flush());
  const FaultyNetwork::Counts& counts = network.counts();
  EXPECT_EQ(counts.datagrams, kSent);
  EXPECT_EQ(arrived, kSent - counts.dropped + counts.doubled);
  EXPECT_GT(counts.dropped, 100U);
  EXPECT_GT(counts.doubled, 100U);
  EXPECT_GT(counts.reordered, 100U);
}

}  // namespace
}  // namespace selfproj::test
