// Tests the device inside a simulation: beats go in and packets come out in turn.
#include "host/driver/sim_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <span>

#include "host/driver/open_device.h"
#include "host/files/user_error.h"
#include "model/packet.h"
#include "tests/host/driver/packets.h"

namespace selfproj::test {
namespace {

using std::chrono::nanoseconds;
constexpr std::size_t kBeat = spec::kPacketBeatBytes;

// Pushes the packet beat by beat; returns the number of beats that were taken.
std::size_t push(SimDevice& device, const Bytes& packet) {
  std::size_t taken = 0;
  for (std::size_t at = 0; at < packet.size(); at += kBeat) {
    taken += device.push(std::span(packet).subspan(at, kBeat), at + kBeat == packet.size()) ? 1 : 0;
  }
  return taken;
}

TEST(SimDevice, BeatsBecomePackets) {
  SimDevice device;
  PacketView packet;
  for (std::uint64_t i = 0; i < 10000; ++i) {
    push(device, moments_packet(i, 32));
    ASSERT_EQ(device.next(packet, nanoseconds(0)), Next::packet);
    ASSERT_EQ(packet.header.sequence, i);
    ASSERT_TRUE(is_intact(packet));
    device.release();
    ASSERT_EQ(device.next(packet, nanoseconds(0)), Next::timeout);
  }
  device.finish();
  EXPECT_EQ(device.next(packet, nanoseconds(0)), Next::end);
  EXPECT_EQ(device.misframed(), 0U);
  EXPECT_EQ(device.counters(), (Counters{.delivered = 10000}));
}

TEST(SimDevice, FullBufferStallsTheBus) {
  SimDevice device(1);  // room for two of the largest packets
  const Bytes first = moments_packet(0, spec::kMaxColumns);
  EXPECT_EQ(push(device, first), first.size() / kBeat);
  EXPECT_EQ(push(device, moments_packet(1, spec::kMaxColumns)), first.size() / kBeat);
  const Bytes beat(kBeat);
  EXPECT_FALSE(device.push(beat, false));
  PacketView packet;
  ASSERT_EQ(device.next(packet, nanoseconds(0)), Next::packet);
  EXPECT_FALSE(device.push(beat, false)) << "the packet that is held would move";
  EXPECT_TRUE(is_intact(packet));
  device.release();
  EXPECT_TRUE(device.push(beat, false));
}

TEST(SimDevice, EndOfPacketAtTheWrongBeat) {
  SimDevice device;
  Bytes packet = moments_packet(0);
  const std::span<const std::uint8_t> bytes(packet);
  device.push(bytes.first(bytes.size() - kBeat), true);  // one beat early
  device.push(bytes.last(kBeat), true);
  push(device, moments_packet(1));
  EXPECT_EQ(device.misframed(), 2U);
  PacketView view;
  EXPECT_EQ(device.next(view, nanoseconds(0)), Next::packet) << "the bytes themselves are right";
}

TEST(SimDevice, NotByUri) { EXPECT_THROW(open_device("sim:"), UserError); }

}  // namespace
}  // namespace selfproj::test
