// Tests what is between simulated FPGAs and the host: RGMII, a network with faults, and packets of PCI Express.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "constraints/acorn/pcie_host.h"
#include "constraints/ecpix5/ethernet.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The check of the digits 1 to 9, as textbooks have it.
TEST(Rgmii, CheckIsCrc32) {
  constexpr std::array<std::uint8_t, 9> kDigits = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(sim::ethernet_check(kDigits), 0xCBF4'3926U);
}

// Frames of any length come as they were sent, short ones filled up; damaged ones do not come.
TEST(Rgmii, FramesComeAsTheyWereSent) {
  Random random(1);
  sim::RgmiiSender sender;
  sim::RgmiiReceiver receiver;
  std::vector<sim::EthernetFrame> due;
  std::uint64_t damaged = 0;
  for (int i = 0; i < 40; ++i) {
    sim::EthernetFrame frame = random.bytes(static_cast<std::size_t>(random.between(14, i % 2 == 0 ? 70 : 1514)));
    const bool damage = random.chance(30);
    sender.send(frame, damage);
    frame.resize(frame.size() < 60 ? 60 : frame.size());
    damaged += damage ? 1 : 0;
    if (!damage) {
      due.push_back(frame);
    }
  }
  std::vector<sim::EthernetFrame> came;
  for (int clock = 0; clock < 100000; ++clock) {
    const sim::RgmiiSender::Pins low = sender.rising();
    receiver.rising(low.control, low.data);
    if (std::optional<sim::EthernetFrame> frame = receiver.falling(sender.falling().data)) {
      came.push_back(*frame);
    }
  }
  EXPECT_EQ(came, due);
  EXPECT_EQ(receiver.damaged(), damaged);
  EXPECT_GT(damaged, 3U);
}

// Only datagrams of the port are hit. What came, less the dropped, plus the doubled, is what arrives.
TEST(FaultyNetwork, CountsWhatItDoes) {
  sim::EthernetFrame datagram(60);
  datagram[12] = 8;
  datagram[14] = 0x45;
  datagram[23] = 17;
  datagram[34] = 1235 >> 8;
  datagram[35] = 1235 & 255;
  sim::EthernetFrame other = datagram;
  other[35] ^= 1;
  sim::FaultyNetwork network(1235, {.dropped = 10, .doubled = 10, .reordered = 10}, 1);
  std::size_t arrived = 0;
  constexpr std::size_t kSent = 2000;
  for (std::size_t i = 0; i < kSent; ++i) {
    arrived += network.pass(datagram).size();
    EXPECT_EQ(network.pass(other).size(), 1U);
  }
  arrived += network.flush() ? 1 : 0;
  EXPECT_FALSE(network.flush());
  const sim::FaultyNetwork::Counts& counts = network.counts();
  EXPECT_EQ(counts.datagrams, kSent);
  EXPECT_EQ(arrived, kSent - counts.dropped + counts.doubled);
  EXPECT_GT(counts.dropped, 100U);
  EXPECT_GT(counts.doubled, 100U);
  EXPECT_GT(counts.reordered, 100U);
}

// What the FPGA sends in one packet, four words a beat.
void send(sim::PcieHost& host, const std::vector<std::uint32_t>& words) {
  for (std::size_t at = 0; at < words.size(); at += 4) {
    sim::PcieHost::From from{.taken = true, .last = at + 4 >= words.size()};
    for (std::size_t i = 0; i < 4 && at + i < words.size(); ++i) {
      from.beat[i] = words[at + i];
      from.keep = static_cast<std::uint16_t>(from.keep | 0xFU << (4 * i));
    }
    host.clock(from);
  }
}

TEST(PcieHost, WritesOfTheFpga) {
  sim::PcieHost host(8192, 100, 1);
  send(host, {0x4000'0002, 0x0100'00FF, sim::PcieHost::kMemory + 8, 0x1122'3344, 0x5566'7788});
  EXPECT_EQ(host.writes(), 1U);
  const std::vector<std::uint8_t> bytes(host.memory().begin() + 8, host.memory().begin() + 16);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88}));
  // A length that is not the packet's, memory that is not the FPGA's, and a boundary of 4 KiB within the packet
  send(host, {0x4000'0003, 0x0100'00FF, sim::PcieHost::kMemory, 1, 2});
  send(host, {0x4000'0001, 0x0100'000F, sim::PcieHost::kMemory + 8192, 1});
  send(host, {0x4000'0001, 0x0100'000F, sim::PcieHost::kMemory - 4, 1});
  send(host, {0x4000'0002, 0x0100'00FF, sim::PcieHost::kMemory + 4092, 1, 2});
  EXPECT_EQ(host.writes(), 1U);
  EXPECT_EQ(host.strangers(), 4U);
}

TEST(PcieHost, AccessesToTheFpga) {
  sim::PcieHost host(4096, 100, 1);
  host.write(0x1'0010, 0x0102'0304);
  host.read(0x1'0014);
  sim::PcieHost::To to = host.clock({});
  EXPECT_TRUE(to.valid && !to.read);
  EXPECT_EQ(to.beat, (sim::PcieHost::Beat{0x4000'0001, 0x0008'000F, 0x1'0010, 0x0403'0201}));
  EXPECT_EQ(host.clock({}).beat, to.beat);  // stays until it is taken
  to = host.clock({.given = true});
  EXPECT_TRUE(to.valid && to.read && host.busy());
  EXPECT_EQ(to.beat[0], 0x0000'0001U);
  EXPECT_FALSE(host.clock({.given = true}).valid);
  EXPECT_FALSE(host.busy());
  EXPECT_FALSE(host.pop_answer());
  send(host, {0x4A00'0001, 0x0100'0004, 0x0008'0014, 0xAABB'CCDD});
  EXPECT_EQ(host.pop_answer(), 0xDDCC'BBAAU);
  EXPECT_FALSE(host.pop_answer());
  EXPECT_EQ(host.strangers(), 0U);
}

}  // namespace
}  // namespace selfproj::test
