// Tests the ring in shared memory: whatever happens to its writer, its reader or itself is counted, and what is read is
// right.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/driver/open_device.h"
#include "host/driver/ring_layout.h"
#include "host/driver/ring_memory.h"
#include "host/driver/ring_writer.h"
#include "host/files/user_error.h"
#include "tests/host/driver/packets.h"
#include "tests/host/driver/ring_fixture.h"

namespace selfproj::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST_F(Ring, PacketsInOrderManyTimesRound) {
  RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  for (std::uint64_t i = 0; i < 100; ++i) {
    write(writer, 10 * i, 10);
    EXPECT_EQ(read(*device), range(10 * i, 10 * i + 9));
  }
  EXPECT_EQ(device->counters(), (Counters{.delivered = 1000}));
}

TEST_F(Ring, LargestPacket) {
  RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  for (std::uint64_t i = 0; i < 3 * kSlots; ++i) {
    ASSERT_TRUE(writer.write(moments_packet(i, spec::kMaxColumns)));
    EXPECT_EQ(read(*device), range(i, i));
  }
  EXPECT_THROW(writer.write(Bytes(kLargestPacketBytes + 1)), std::invalid_argument);
}

TEST_F(Ring, HeldPacketIsNotOverwritten) {
  RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  write(writer, 0, 1);
  PacketView packet;
  ASSERT_EQ(device->next(packet, nanoseconds(0)), Next::packet);
  write(writer, 1, 100);
  EXPECT_TRUE(is_intact(packet));
  EXPECT_EQ(packet.header.sequence, 0U);
  device->release();
  EXPECT_EQ(read(*device), range(1, kSlots - 1));
  EXPECT_EQ(device->counters().lost_ring, 101 - kSlots);
}

TEST_F(Ring, ReaderSlowerThanBoard) {
  RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  write(writer, 0, kSlots + 5);
  EXPECT_EQ(writer.lost(), 5U);
  EXPECT_EQ(read(*device), range(0, kSlots - 1));
  EXPECT_EQ(device->counters().lost_ring, 5U);
  EXPECT_EQ(device->counters().missing, 0U) << "no later packet yet";
  write(writer, kSlots + 5, 3);
  EXPECT_EQ(read(*device), range(kSlots + 5, kSlots + 7));
  EXPECT_EQ(device->counters(), (Counters{.delivered = kSlots + 3, .lost_ring = 5, .missing = 5}));
}

TEST_F(Ring, BoardRestarted) {
  const auto reader_first = open_patient();
  EXPECT_TRUE(read(*reader_first).empty());
  {
    RingWriter writer(name_, kSlots);
    write(writer, 0, 5);
  }
  PacketView packet;
  ASSERT_EQ(reader_first->next(packet, seconds(10)), Next::packet) << "finds the ring";
  EXPECT_EQ(read(*reader_first), range(1, 4));
  {
    RingWriter writer(name_, kSlots);
    write(writer, 0, 3);
    EXPECT_EQ(info().board_crashes, 0U);
  }
  EXPECT_EQ(read(*reader_first), range(0, 2));
  EXPECT_EQ(reader_first->counters(), (Counters{.delivered = 8, .restarts = 1, .reattached = 1}));
  EXPECT_EQ(info().boards, 2U);
}

TEST_F(Ring, EndWhenTheBoardHasGone) {
  auto writer = std::make_unique<RingWriter>(name_, kSlots);
  const auto device = open_ring();
  write(*writer, 0, 3);
  PacketView packet;
  EXPECT_EQ(read(*device), range(0, 2));
  EXPECT_EQ(device->next(packet, milliseconds(60)), Next::timeout);
  write(*writer, 3, 2);
  writer.reset();
  EXPECT_EQ(read(*device), range(3, 4)) << "what is left comes first";
  EXPECT_EQ(device->next(packet, seconds(10)), Next::end);
}

TEST_F(Ring, RemovedAndMadeAgain) {
  RingWriter writer(name_, kSlots);
  const auto device = open_patient();
  write(writer, 0, 3);
  ASSERT_TRUE(remove_ring(name_));
  EXPECT_FALSE(remove_ring(name_));
  EXPECT_EQ(read(*device), range(0, 2)) << "what was in it is not lost";
  PacketView packet;
  EXPECT_EQ(device->next(packet, milliseconds(120)), Next::timeout);
  write(writer, 3, 2);
  EXPECT_EQ(read(*device), range(3, 4)) << "as long as the writer writes there, the reader reads there";
  write(writer, 5, 1);
  EXPECT_TRUE(writer.renew_if_removed());
  EXPECT_FALSE(writer.renew_if_removed());
  write(writer, 10, 2);
  EXPECT_EQ(read(*device), range(5, 5)) << "first the old ring";
  ASSERT_EQ(device->next(packet, seconds(10)), Next::packet);
  EXPECT_EQ(packet.header.sequence, 10U);
  EXPECT_EQ(device->counters().reattached, 1U);
  EXPECT_EQ(device->counters().missing, 4U);
}

TEST_F(Ring, ReplacedByOneOfAnotherSize) {
  const auto device = open_patient();
  { RingWriter(name_, 16).write(moments_packet(0)); }
  PacketView packet;
  ASSERT_EQ(device->next(packet, seconds(10)), Next::packet);
  device->release();
  RingWriter writer(name_, 64);
  writer.write(moments_packet(1));
  ASSERT_EQ(device->next(packet, seconds(10)), Next::packet);
  EXPECT_EQ(packet.header.sequence, 1U);
  EXPECT_EQ(device->counters().reattached, 1U);
}

// Runs `work` in a child process that is then killed.
template <typename Work>
void run_and_kill(const Work& work) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    work();
    static_cast<void>(::write(ready[1], "x", 1));
    for (;;) {
      pause();
    }
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ready[0]);
  close(ready[1]);
}

TEST_F(Ring, ReaderCrashed) {
  RingWriter writer(name_, kSlots);
  write(writer, 0, 5);
  run_and_kill([&] {
    const auto device = open_ring().release();  // as a crash leaves it: never closed
    PacketView packet;
    device->next(packet, nanoseconds(0));
    device->release();
    device->next(packet, nanoseconds(0));  // held
  });
  EXPECT_FALSE(info().reader);
  EXPECT_EQ(info().reader_crashes, 1U);
  const auto device = open_ring();
  EXPECT_TRUE(info().reader);
  EXPECT_EQ(read(*device), range(1, 4)) << "what was held is read once more";
  EXPECT_EQ(info().reader_crashes, 1U);
  EXPECT_EQ(info().readers, 2U);
}

// Losses while nobody reads are counted, and the next reader reports them.
TEST_F(Ring, LossesWhileThereIsNoReaderAreCountedByTheNext) {
  RingWriter writer(name_, kSlots);
  { const auto device = open_ring(); }
  write(writer, 0, kSlots + 7);
  const auto device = open_ring();
  EXPECT_EQ(read(*device), range(0, kSlots - 1));
  write(writer, kSlots + 7, 1);
  EXPECT_EQ(read(*device), range(kSlots + 7, kSlots + 7));
  EXPECT_EQ(device->counters(), (Counters{.delivered = kSlots + 1, .lost_ring = 7, .missing = 7}));
}

TEST_F(Ring, BoardCrashed) {
  const auto device = open_patient();
  run_and_kill([&] {
    auto* writer = new RingWriter(name_, kSlots);
    write(*writer, 0, 5);
    // In the middle of a packet.
    const auto place = writer->claim();
    std::fill_n(place.begin(), 100, std::uint8_t{0xFF});
  });
  PacketView packet;
  ASSERT_EQ(device->next(packet, seconds(10)), Next::packet);
  device->release();
  EXPECT_EQ(read(*device), range(1, 4));
  EXPECT_FALSE(info().board);
  EXPECT_EQ(info().board_crashes, 1U);
  RingWriter writer(name_, kSlots);
  write(writer, 0, 2);
  EXPECT_EQ(read(*device), range(0, 1));
  EXPECT_EQ(device->counters(), (Counters{.delivered = 7, .restarts = 1, .reattached = 1}));
  EXPECT_EQ(info().board_crashes, 1U);
}

TEST_F(Ring, DiscardBacklog) {
  RingWriter writer(name_, kSlots);
  write(writer, 0, 5);
  const auto device = open_ring({.discard_backlog = true});
  EXPECT_TRUE(read(*device).empty());
  write(writer, 5, 1);
  EXPECT_EQ(read(*device), range(5, 5));
}

TEST_F(Ring, DamagedSlots) {
  RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  ring::Memory memory;
  ASSERT_EQ(memory.attach(ring::shared_name(name_).c_str()), ring::Memory::Found::ring);
  write(writer, 0, 8);
  memory.packet(1)[70] ^= 1;          // the packet
  memory.slot(3).number += kSlots;    // its number
  memory.slot(5).bytes = 0xFFFFFFFF;  // its length
  EXPECT_EQ(read(*device), (std::vector<std::uint64_t>{0, 2, 4, 6, 7}));
  EXPECT_EQ(device->counters().bad, 3U);
  EXPECT_EQ(device->counters().resynchronized, 3U);
  EXPECT_EQ(device->counters().missing, 3U);
  // An impossible count.
  memory.header().written.fetch_add(1000);
  EXPECT_TRUE(read(*device).empty());
  EXPECT_EQ(device->counters().bad, 4U);
}

TEST_F(Ring, OneWriterOneReader) {
  EXPECT_THROW(open_ring(), UserError) << "no ring";
  RingWriter writer(name_, kSlots);
  EXPECT_THROW(RingWriter(name_, kSlots), UserError);
  const auto device = open_ring();
  EXPECT_THROW(open_ring(), UserError);
  EXPECT_TRUE(info().board);
  EXPECT_TRUE(info().reader);
  EXPECT_EQ(info().board_pid, static_cast<std::uint32_t>(getpid()));
  EXPECT_TRUE(writer.has_reader());
}

TEST_F(Ring, BadNamesAndSizes) {
  for (const char* name : {"", "a/b", "..//x", "a b"}) {
    EXPECT_THROW(RingWriter(name, kSlots), UserError) << name;
    EXPECT_THROW(open_device(std::string("ring:") + name), UserError) << name;
  }
  for (const std::uint32_t slots : {0U, 3U, 131072U}) {
    EXPECT_THROW(RingWriter(name_, slots), UserError) << slots;
  }
}

TEST_F(Ring, OfAnotherLayout) {
  const std::string shared = ring::shared_name(name_);
  { RingWriter writer(name_, kSlots); }
  {
    ring::Memory memory;
    memory.attach(shared.c_str());
    memory.header().spec_hash ^= 1;
  }
  EXPECT_THROW(open_ring(), UserError);
  EXPECT_NE(info().problem, "");
  RingWriter writer(name_, kSlots);  // replaces it
  EXPECT_EQ(info().problem, "");
}

TEST_F(Ring, InterruptedWhileItWasMade) {
  const int descriptor = shm_open(ring::shared_name(name_).c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(ftruncate(descriptor, 5000), 0);
  close(descriptor);
  EXPECT_THROW(open_ring(), UserError);
  EXPECT_EQ(info().problem, "not complete");
  RingWriter writer(name_, kSlots);
  EXPECT_NO_THROW(open_ring());
}

TEST_F(Ring, NoRoomForIt) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{100000, before.rlim_max};
  signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(RingWriter(name_, 1024), UserError);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_EQ(info().name, "") << "nothing half made is left";
}

}  // namespace
}  // namespace selfproj::test
