// Tests packets in datagrams: lost, doubled, reordered, cut and foreign ones, and boards that go and come back.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/driver/datagram_assembler.h"
#include "host/driver/open_device.h"
#include "host/files/user_error.h"
#include "model/datagram.h"
#include "sim/board/udp_sender.h"
#include "tests/host/driver/packets.h"
#include "tests/support/datagram_network.h"

namespace selfproj::test {
namespace {

using std::chrono::milliseconds;

// The datagrams of packets first..first + count - 1, which are of different sizes, and of the idle sender at the end.
std::vector<Bytes> cut_up(DatagramCutter& cutter, std::uint64_t first, int count) {
  std::vector<Bytes> datagrams;
  const auto keep = [&](std::span<const std::uint8_t> datagram) {
    datagrams.emplace_back(datagram.begin(), datagram.end());
  };
  for (int i = 0; i < count; ++i) {
    const std::uint64_t sequence = first + static_cast<std::uint64_t>(i);
    cutter.packet(moments_packet(sequence, sequence % 3 == 0 ? 16 : 512), keep);
  }
  for (int i = 0; i < 3; ++i) {
    cutter.idle(keep);
  }
  return datagrams;
}

// Gives the datagrams to the assembler. All packets given must be intact, in order, and given once.
std::vector<std::uint64_t> assemble(DatagramAssembler& assembler, const std::vector<Bytes>& datagrams) {
  std::vector<std::uint64_t> sequences;
  PacketView packet;
  const auto drain = [&] {
    while (assembler.next(packet)) {
      EXPECT_TRUE(is_intact(packet));
      EXPECT_TRUE(sequences.empty() || packet.header.sequence > sequences.back());
      sequences.push_back(packet.header.sequence);
    }
  };
  for (const Bytes& datagram : datagrams) {
    do {
      drain();
    } while (!assembler.add(datagram));
  }
  drain();
  assembler.flush();
  drain();
  return sequences;
}

TEST(Datagrams, GoodNetwork) {
  for (const std::size_t size : {kDatagramBytes, kJumboDatagramBytes}) {
    Counters counters;
    DatagramAssembler assembler(counters);
    DatagramCutter cutter(7, size);
    EXPECT_EQ(assemble(assembler, cut_up(cutter, 0, 300)).size(), 300U);
    EXPECT_EQ(counters, Counters{});
  }
}

TEST(Datagrams, DeliveredAndCountedIsSent) {
  for (const std::uint64_t seed : seeds(12)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int kind = static_cast<int>(seed % 6);
    const Faults faults{.dropped = kind == 0 || kind > 3 ? 1 : 0,
                        .doubled = kind == 1 || kind > 3 ? 1 : 0,
                        .reordered = kind == 2 || kind > 3 ? (kind == 5 ? 20 : 1) : 0,
                        .cut = kind == 3 || kind > 3 ? 1 : 0};
    DatagramCutter cutter(static_cast<std::uint16_t>(seed));
    const std::vector<Bytes> sent = cut_up(cutter, 0, 400);
    const Network network(sent, faults, random);
    Counters counters;
    DatagramAssembler assembler(counters);
    const std::vector<std::uint64_t> got = assemble(assembler, network.datagrams);
    EXPECT_EQ(got.size() + counters.lost_network, 400U);
    EXPECT_EQ(counters.bad, 0U);
    EXPECT_EQ(counters.datagrams_refused, network.cut);
    EXPECT_EQ(counters.datagrams_lost, network.dropped + network.cut);
    EXPECT_EQ(counters.datagrams_doubled, network.doubled);
    EXPECT_EQ(counters.datagrams_reordered > 0, faults.reordered > 0);
    EXPECT_EQ(counters.lost_network > 0, network.dropped + network.cut > 0);
  }
}

TEST(Datagrams, NumbersWrapAndAReaderComesLate) {
  Counters counters;
  DatagramAssembler assembler(counters);
  DatagramCutter cutter(9);
  std::vector<Bytes> sent = cut_up(cutter, 0, 20);
  for (Bytes& datagram : sent) {  // as after 2^32 - 9 packets
    DatagramHeader header = *read_datagram_header(datagram);
    header.sequence -= 20;
    header.packet -= 9;
    write_datagram_header(header, datagram.data());
  }
  sent.erase(sent.begin() + 1, sent.begin() + 3);  // begins in packet 1, which has three pieces
  sent.erase(sent.begin());
  EXPECT_EQ(assemble(assembler, sent).size(), 18U);
  EXPECT_EQ(counters.lost_network + counters.datagrams_lost, 0U);
  EXPECT_GT(counters.bytes_discarded, 0U);
}

// A frame of Ethernet can be too short for the header alone.
TEST(Datagrams, WithoutAPieceTheyMayBeFilledUp) {
  Bytes idle;
  DatagramCutter(1).idle(
      [&](std::span<const std::uint8_t> datagram) { idle.assign(datagram.begin(), datagram.end()); });
  for (const std::size_t filling : {std::size_t{0}, std::size_t{4}, std::size_t{16}, std::size_t{17}}) {
    Bytes datagram = idle;
    datagram.resize(idle.size() + filling);
    EXPECT_EQ(read_datagram_header(datagram).has_value(), filling <= 16) << filling;
  }
}

TEST(Datagrams, NewSessionAndALateOneOfTheOld) {
  Counters counters;
  DatagramAssembler assembler(counters);
  DatagramCutter first(1);
  std::vector<Bytes> all = cut_up(first, 0, 9);
  all.resize(all.size() - 4);  // it was cut off in its last packet
  const Bytes late = all.back();
  DatagramCutter second(2);
  const std::vector<Bytes> more = cut_up(second, 100, 10);
  all.insert(all.end(), more.begin(), more.end());
  all.insert(all.end() - 5, late);
  const std::vector<std::uint64_t> got = assemble(assembler, all);
  EXPECT_EQ(got.size() + counters.lost_network, 19U);
  EXPECT_EQ(counters.lost_network, 1U);
  EXPECT_EQ(got.back(), 109U);
  EXPECT_EQ(counters.reattached, 1U);
  EXPECT_EQ(counters.datagrams_refused, 1U);
}

// Bytes of any kind neither break it nor become a packet.
TEST(Datagrams, RandomBytes) {
  for (const std::uint64_t seed : seeds(4)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    Counters counters;
    DatagramAssembler assembler(counters);
    DatagramCutter cutter(3);
    std::vector<Bytes> all = cut_up(cutter, 0, 100);
    for (Bytes& datagram : all) {
      for (int flips = random.between(0, 3); flips > 0; --flips) {
        const int most =
            random.chance(80) ? static_cast<int>(spec::kDatagramHeaderBytes) : static_cast<int>(datagram.size());
        datagram[static_cast<std::size_t>(random.between(2, most - 1))] ^=
            static_cast<std::uint8_t>(random.between(1, 255));
      }
      if (random.chance(5)) {
        datagram = random.bytes(static_cast<std::size_t>(random.between(0, 3000)));
      }
    }
    PacketView packet;
    for (const Bytes& datagram : all) {
      int steps = 0;
      do {
        while (assembler.next(packet)) {
          EXPECT_TRUE(is_intact(packet));
        }
        ASSERT_LT(++steps, 10);
      } while (!assembler.add(datagram));
    }
  }
}

// --- sockets on loopback: boards are at 127.0.0.2, the host at 127.0.0.1 ---

constexpr int kFirstPort = 20000;

class UdpDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    port_ = std::to_string(kFirstPort + getpid() % kFirstPort);
    device_ = open_device("udp:127.0.0.2:" + port_);
  }

  [[nodiscard]] UdpSender board(const std::string& from = "127.0.0.2") const {
    return {"127.0.0.1:" + port_, from, false};
  }

  std::uint64_t read(std::uint64_t most) {
    PacketView packet;
    std::uint64_t count = 0;
    while (count < most && device_->next(packet, milliseconds(300)) == Next::packet) {
      EXPECT_TRUE(is_intact(packet));
      device_->release();
      ++count;
    }
    return count;
  }

  std::string port_;
  std::unique_ptr<Device> device_;
};

TEST_F(UdpDevice, PacketsOfOneBoardOnly) {
  UdpSender sender = board();
  UdpSender stranger = board("127.0.0.3");
  for (std::uint64_t i = 0; i < 50; ++i) {
    sender.send(moments_packet(i, 512));
    stranger.send(moments_packet(1000 + i, 512));
  }
  sender.finish();
  stranger.finish();
  EXPECT_EQ(read(1000), 50U);
  EXPECT_EQ(device_->counters(), (Counters{.delivered = 50}));
  EXPECT_EQ(device_->uri(), "udp:127.0.0.2:" + port_);
}

TEST_F(UdpDevice, UnpluggedAndBack) {
  {
    UdpSender sender = board();
    for (std::uint64_t i = 0; i < 20; ++i) {
      sender.send(moments_packet(i, 512));
    }
    EXPECT_EQ(read(20), 20U);
  }
  EXPECT_EQ(read(1), 0U);  // nothing comes, and that is no end
  UdpSender sender = board();
  for (std::uint64_t i = 30; i < 50; ++i) {
    sender.send(moments_packet(i, 512));
  }
  EXPECT_EQ(read(20), 20U);
  EXPECT_EQ(device_->counters(), (Counters{.delivered = 40, .missing = 10, .reattached = 1}));
}

// The socket's buffer is full: what did not fit is known, and what comes later is whole.
TEST_F(UdpDevice, ASlowReader) {
  UdpSender sender = board();
  std::uint64_t sent = 0;
  for (; sent < 6000; ++sent) {
    sender.send(moments_packet(sent, 2048));
  }
  const std::uint64_t first = read(100000);
  for (std::uint64_t i = 0; i < 10; ++i) {
    sender.send(moments_packet(sent++, 512));
  }
  EXPECT_EQ(read(100), 10U);
  const Counters counters = device_->counters();
  EXPECT_EQ(first + 10 + counters.lost_network, sent);
  EXPECT_EQ(counters.datagrams_overflow, counters.datagrams_lost);
  EXPECT_GT(counters.datagrams_overflow, 0U);
}

TEST(UdpPlace, WhatIsNoPlace) {
  const auto error = [](const std::string& uri) {
    try {
      open_device(uri);
    } catch (const UserError& problem) {
      return std::string(problem.what());
    }
    return std::string();
  };
  EXPECT_EQ(error("udp:"), "udp:: the name of the host is missing");
  EXPECT_EQ(error("udp:127.0.0.2:0"), "udp:127.0.0.2:0: '0' is not a port, 1 to 65535");
  EXPECT_EQ(error("udp:127.0.0.2:1x"), "udp:127.0.0.2:1x: '1x' is not a port, 1 to 65535");
  EXPECT_NE(error("udp:no.such.host.invalid").find("is not known"), std::string::npos);
}

}  // namespace
}  // namespace selfproj::test
