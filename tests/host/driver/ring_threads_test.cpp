// Tests the ring in shared memory while writer and reader run in parallel, come and go, and run for a long time.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>

#include "host/driver/ring_writer.h"
#include "selfproj/driver/device.h"
#include "tests/host/driver/packets.h"
#include "tests/host/driver/ring_fixture.h"
#include "tests/support/allocations.h"

namespace selfproj::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

using RingThreads = Ring;

// Writer and reader run in parallel at full speed, with each way of waiting. With back pressure nothing may be lost.
TEST_F(RingThreads, TwoThreads) {
  constexpr std::uint64_t kCount = 3000;
  for (const driver::Wait wait : {driver::Wait::polling, driver::Wait::blocking, driver::Wait::polling_then_blocking}) {
    driver::RingWriter writer(name_, kSlots);
    const auto device = open_ring({.wait = wait});
    std::thread board([&] {
      for (std::uint64_t i = 0; i < kCount; ++i) {
        while (writer.unread() >= kSlots) {
          std::this_thread::yield();
        }
        writer.write(moments_packet(i));
      }
    });
    model::PacketView packet;
    std::uint64_t expected = 0;
    while (expected < kCount && device->next(packet, seconds(10)) == driver::Next::packet) {
      ASSERT_EQ(packet.header.sequence, expected++);
      ASSERT_TRUE(is_intact(packet));
      device->release();
    }
    board.join();
    EXPECT_EQ(device->counters(), (driver::Counters{.delivered = kCount}));
  }
}

// The same without back pressure and with a slow reader: every loss is counted, to the last packet.
TEST_F(RingThreads, TwoThreadsWithLosses) {
  constexpr std::uint64_t kCount = 50000;
  const auto device = open_patient();
  std::thread board([&] {
    driver::RingWriter writer(name_, kSlots);
    for (std::uint64_t i = 0; i < kCount; ++i) {
      writer.write(moments_packet(i, 4));
    }
    while (!writer.write(moments_packet(kCount, 4))) {  // so that the last gap is seen
      std::this_thread::sleep_for(milliseconds(1));
    }
  });
  model::PacketView packet;
  Random random(1);
  std::uint64_t last = 0;
  while (last < kCount && device->next(packet, seconds(10)) == driver::Next::packet) {
    ASSERT_TRUE(is_intact(packet));
    last = packet.header.sequence;
    if (random.chance(2)) {
      std::this_thread::sleep_for(std::chrono::microseconds(random.between(1, 300)));
    }
  }
  board.join();
  const driver::Counters counters = device->counters();
  EXPECT_EQ(counters.bad, 0U);
  EXPECT_LE(counters.delivered + counters.missing, kCount + 1);
  EXPECT_EQ(counters.delivered + counters.lost_ring, kCount + 1 + (counters.lost_ring - counters.missing));
}

// A reader and a board come and go 10^4 times. Everything that was written is read whole and in order.
TEST_F(RingThreads, TenThousandStartsAndStops) {
  Random random(1);
  auto writer = std::make_unique<driver::RingWriter>(name_, kSlots);
  model::PacketView packet;
  std::uint64_t written = 0;
  std::uint64_t expected = 0;
  for (int i = 0; i < 10000; ++i) {
    const int count = random.between(0, 5);
    write(*writer, written, count);
    written += static_cast<std::uint64_t>(count);
    if (random.chance(20)) {
      writer.reset();
      writer = std::make_unique<driver::RingWriter>(name_, kSlots);
    }
    const auto device = open_ring();
    for (int reads = random.between(written - expected > 10 ? 5 : 0, 6);
         reads > 0 && device->next(packet, nanoseconds(0)) == driver::Next::packet; --reads) {
      ASSERT_TRUE(is_intact(packet));
      ASSERT_EQ(packet.header.sequence, expected++) << "start " << i;
      if (random.chance(50)) {
        device->release();  // closing with the packet in hand counts it as read
      }
    }
    ASSERT_EQ(device->counters().bad + device->counters().lost_ring, 0U);
  }
  EXPECT_EQ(info().reader_crashes + info().board_crashes, 0U);
  EXPECT_EQ(info().readers, 10000U);
}

// The same while the board goes on writing in its own time.
TEST_F(RingThreads, ReadersComeAndGoWhileTheBoardWrites) {
  driver::RingWriter writer(name_, kSlots);
  std::atomic<bool> stop{false};
  std::thread board([&] {
    for (std::uint64_t i = 0; !stop; ++i) {
      writer.write(moments_packet(i));
    }
  });
  std::uint64_t next_sequence = 0;
  model::PacketView packet;
  for (int i = 0; i < 300; ++i) {
    const auto device = open_ring({.discard_backlog = i % 2 == 0});
    for (int k = 0; k < 3 && device->next(packet, seconds(10)) == driver::Next::packet; ++k) {
      EXPECT_TRUE(is_intact(packet));
      EXPECT_GE(packet.header.sequence, next_sequence);
      next_sequence = packet.header.sequence + 1;
      device->release();
    }
    EXPECT_EQ(device->counters().delivered, 3U);
    EXPECT_EQ(device->counters().bad, 0U);
  }
  stop = true;
  board.join();
  EXPECT_EQ(info().reader_crashes, 0U);
}

TEST_F(RingThreads, AllocatesNothingAfterTheStart) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_patient();
  const Bytes one = moments_packet(0);
  const Bytes two = moments_packet(1);
  model::PacketView packet;
  const std::uint64_t before = allocations();
  for (int i = 0; i < 1000; ++i) {
    writer.write(one);
    writer.write(two);
    device->next(packet, nanoseconds(0));
    device->next(packet, nanoseconds(0));
    device->next(packet, nanoseconds(1000));
    device->release();
    static_cast<void>(device->counters());
  }
  EXPECT_EQ(allocations(), before);
}

}  // namespace
}  // namespace selfproj::test
