// Tests the ring in shared memory: whatever happens to its writer, its reader or itself is counted, and what is read is
// right.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/ring_memory.h"
#include "host/driver/ring_writer.h"
#include "host/files/file_descriptor.h"
#include "selfproj/driver/device.h"
#include "selfproj/files/user_error.h"
#include "tests/host/driver/packets.h"
#include "tests/host/driver/ring_fixture.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST_F(Ring, PacketsInOrderManyTimesRound) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  for (std::uint64_t i = 0; i < 100; ++i) {
    write(writer, 10 * i, 10);
    EXPECT_EQ(read(*device), range(10 * i, 10 * i + 9));
  }
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 1000}));
}

TEST_F(Ring, LargestPacket) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  for (std::uint64_t i = 0; i < 3 * kSlots; ++i) {
    ASSERT_TRUE(writer.write(moments_packet(i, spec::kMaxColumns)));
    EXPECT_EQ(read(*device), range(i, i));
  }
  ASSERT_TRUE(writer.write(largest_packet(3 * kSlots)));
  EXPECT_EQ(read(*device), range(3 * kSlots, 3 * kSlots));
  EXPECT_THROW(writer.write(Bytes(model::kLargestPacketBytes + 1)), std::invalid_argument);
}

TEST_F(Ring, HeldPacketIsNotOverwritten) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  write(writer, 0, 1);
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, nanoseconds(0)), driver::Next::packet);
  write(writer, 1, 100);
  EXPECT_TRUE(is_intact(packet));
  EXPECT_EQ(packet.header.sequence, 0U);
  device->release();
  EXPECT_EQ(read(*device), range(1, kSlots - 1));
  EXPECT_EQ(device->counters().lost_ring, 101 - kSlots);
}

TEST_F(Ring, ReaderSlowerThanBoard) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  write(writer, 0, kSlots + 5);
  EXPECT_EQ(writer.lost(), 5U);
  EXPECT_EQ(read(*device), range(0, kSlots - 1));
  EXPECT_EQ(device->counters().lost_ring, 5U);
  EXPECT_EQ(device->counters().missing, 0U) << "no later packet yet";
  write(writer, kSlots + 5, 3);
  EXPECT_EQ(read(*device), range(kSlots + 5, kSlots + 7));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = kSlots + 3, .lost_ring = 5, .missing = 5}));
}

TEST_F(Ring, BoardRestarted) {
  const auto reader_first = open_patient();
  EXPECT_TRUE(read(*reader_first).empty());
  {
    driver::RingWriter writer(name_, kSlots);
    write(writer, 0, 5);
  }
  model::PacketView packet;
  ASSERT_EQ(reader_first->next(packet, seconds(10)), driver::Next::packet) << "finds the ring";
  EXPECT_EQ(read(*reader_first), range(1, 4));
  {
    driver::RingWriter writer(name_, kSlots);
    write(writer, 0, 3);
    EXPECT_EQ(info().board_crashes, 0U);
  }
  EXPECT_EQ(read(*reader_first), range(0, 2));
  EXPECT_EQ(reader_first->counters(), (driver::Counters{.delivered = 8, .restarts = 1, .reattached = 1}));
  EXPECT_EQ(info().boards, 2U);
}

// What a reader has read before the ring was removed is not lost; the rest is, because nobody can read it any more.
TEST_F(Ring, RemovedWithoutAReader) {
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, 7);
  EXPECT_EQ(read(*open_ring()), range(0, 6));
  write(writer, 7, 3);
  ASSERT_TRUE(driver::remove_ring(name_));
  EXPECT_TRUE(writer.renew_if_removed());
  EXPECT_EQ(writer.lost(), 3U);
  EXPECT_EQ(open_ring()->counters().lost_ring, 3U);
}

TEST_F(Ring, EndWhenTheBoardHasGone) {
  auto writer = std::make_unique<driver::RingWriter>(name_, kSlots);
  const auto device = open_ring();
  write(*writer, 0, 3);
  model::PacketView packet;
  EXPECT_EQ(read(*device), range(0, 2));
  EXPECT_EQ(device->next(packet, milliseconds(60)), driver::Next::timeout);
  write(*writer, 3, 2);
  writer.reset();
  EXPECT_EQ(read(*device), range(3, 4)) << "what is left comes first";
  EXPECT_EQ(device->next(packet, seconds(10)), driver::Next::end);
}

TEST_F(Ring, RemovedAndMadeAgain) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_patient();
  write(writer, 0, 3);
  ASSERT_TRUE(driver::remove_ring(name_));
  EXPECT_FALSE(driver::remove_ring(name_));
  EXPECT_EQ(read(*device), range(0, 2)) << "what was in it is not lost";
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, milliseconds(120)), driver::Next::timeout);
  write(writer, 3, 2);
  EXPECT_EQ(read(*device), range(3, 4)) << "as long as the writer writes there, the reader reads there";
  write(writer, 5, 1);
  EXPECT_TRUE(writer.renew_if_removed());
  EXPECT_FALSE(writer.renew_if_removed());
  write(writer, 10, 2);
  EXPECT_EQ(read(*device), range(5, 5)) << "first the old ring";
  ASSERT_EQ(device->next(packet, seconds(10)), driver::Next::packet);
  EXPECT_EQ(packet.header.sequence, 10U);
  EXPECT_EQ(device->counters().reattached, 1U);
  EXPECT_EQ(device->counters().missing, 4U);
}

TEST_F(Ring, ReplacedByOneOfAnotherSize) {
  const auto device = open_patient();
  { driver::RingWriter(name_, 16).write(moments_packet(0)); }
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, seconds(10)), driver::Next::packet);
  device->release();
  driver::RingWriter writer(name_, 64);
  writer.write(moments_packet(1));
  ASSERT_EQ(device->next(packet, seconds(10)), driver::Next::packet);
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
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, 5);
  run_and_kill([&] {
    const auto device = open_ring().release();  // as a crash leaves it: never closed
    model::PacketView packet;
    device->next(packet, nanoseconds(0));
    device->release();
    device->next(packet, nanoseconds(0));  // held
  });
  EXPECT_FALSE(info().reader);
  EXPECT_FALSE(writer.has_reader());
  EXPECT_EQ(info().reader_crashes, 1U);
  EXPECT_NE(info().reader_pid, info().board_pid);
  const auto device = open_ring();
  EXPECT_EQ(info().reader_pid, static_cast<std::uint32_t>(getpid()));
  EXPECT_TRUE(info().reader);
  EXPECT_EQ(read(*device), range(1, 4)) << "what was held is read once more";
  EXPECT_EQ(info().reader_crashes, 1U);
  EXPECT_EQ(info().readers, 2U);
}

// Losses while nobody reads are counted, and the next reader reports them.
TEST_F(Ring, LossesWhileThereIsNoReaderAreCountedByTheNext) {
  driver::RingWriter writer(name_, kSlots);
  { const auto device = open_ring(); }
  write(writer, 0, kSlots + 7);
  const auto device = open_ring();
  EXPECT_EQ(read(*device), range(0, kSlots - 1));
  write(writer, kSlots + 7, 1);
  EXPECT_EQ(read(*device), range(kSlots + 7, kSlots + 7));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = kSlots + 1, .lost_ring = 7, .missing = 7}));
}

TEST_F(Ring, BoardCrashed) {
  const auto device = open_patient();
  run_and_kill([&] {
    auto* writer = new driver::RingWriter(name_, kSlots);
    write(*writer, 0, 5);
    // In the middle of a packet.
    const auto place = writer->claim();
    std::fill_n(place.begin(), 100, std::uint8_t{0xFF});
  });
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, seconds(10)), driver::Next::packet);
  device->release();
  EXPECT_EQ(read(*device), range(1, 4));
  EXPECT_FALSE(info().board);
  EXPECT_EQ(info().board_crashes, 1U);
  driver::RingWriter writer(name_, kSlots);
  EXPECT_EQ(info().board_pid, static_cast<std::uint32_t>(getpid()));
  write(writer, 0, 2);
  EXPECT_EQ(read(*device), range(0, 1));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 7, .restarts = 1, .reattached = 1}));
  EXPECT_EQ(info().board_crashes, 1U);
}

// A board that is killed and whose ring is removed does not end as one that has ended by itself: the reader waits for
// its new ring, and counts a fault, which --check refuses.
TEST_F(Ring, LongRemovedAndNotMadeAgain) {
  std::unique_ptr<driver::Device> device;
  run_and_kill([&] {
    auto* writer = new driver::RingWriter(name_, kSlots);
    write(*writer, 0, 3);
  });
  device = open_ring();
  ASSERT_TRUE(driver::remove_ring(name_));
  EXPECT_EQ(read(*device), range(0, 2)) << "what was in it is not lost";
  model::PacketView packet;
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(device->next(packet, seconds(20)), driver::Next::end);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(2500));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 3, .read_errors = 1}));

  // A board that ends removes its ring itself.
  auto writer = std::make_unique<driver::RingWriter>(name_, kSlots);
  device = open_ring();
  write(*writer, 3, 2);
  writer.reset();
  ASSERT_TRUE(driver::remove_ring(name_));
  EXPECT_EQ(read(*device), range(3, 4));
  EXPECT_EQ(device->next(packet, seconds(20)), driver::Next::end);
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 2}));
}

TEST_F(Ring, DiscardBacklog) {
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, kSlots + 5);
  const auto device = open_ring({.discard_backlog = true});
  EXPECT_TRUE(read(*device).empty());
  write(writer, kSlots + 5, 1);
  EXPECT_EQ(read(*device), range(kSlots + 5, kSlots + 5));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 1})) << "what was lost before is not this reader's loss";
}

// What a board writes after the device was opened is no backlog, even if the reader has not looked yet.
TEST_F(Ring, WhatComesAfterOpeningIsNotDiscarded) {
  const auto device = driver::open_device("ring:" + name_, {.wait_for_board = true, .discard_backlog = true});
  EXPECT_TRUE(read(*device).empty());
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, 3);
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, seconds(20)), driver::Next::packet);
  EXPECT_EQ(packet.header.sequence, 0U);
  EXPECT_EQ(read(*device), range(1, 2));
}

TEST_F(Ring, DamagedSlots) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  driver::ring::Memory memory;
  ASSERT_EQ(memory.attach(driver::ring::shared_name(name_).c_str()), driver::ring::Memory::Found::ring);
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

TEST_F(Ring, EachDamageIsCountedToTheByte) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  write(writer, 0, 1);
  Bytes other = moments_packet(1);
  model::replace_header(other, moments_header(1), spec::kHash ^ 1U);
  writer.write(other);
  writer.write(Bytes(50));
  driver::ring::Memory memory;
  ASSERT_EQ(memory.attach(driver::ring::shared_name(name_).c_str()), driver::ring::Memory::Found::ring);
  write(writer, 2, 2);
  memory.slot(3).bytes = 0xFFFFFFFF;
  memory.slot(4).bytes += 16;
  write(writer, 4, 1);
  EXPECT_EQ(read(*device), (std::vector<std::uint64_t>{0, 4}));
  const std::uint64_t size = other.size();
  EXPECT_EQ(device->counters(),
            (driver::Counters{.delivered = 2,
                              .missing = 3,
                              .bad = 4,
                              .other_spec = 1,
                              .resynchronized = 1,
                              .bytes_discarded = size + 50 + model::kLargestPacketBytes + size + 16}));
}

// After each impossible count the reader is at the newest packet, and finds the next.
TEST_F(Ring, ImpossibleCountsWhileItReads) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  write(writer, 0, 3);
  EXPECT_EQ(read(*device), range(0, 2));
  driver::ring::Memory memory;
  ASSERT_EQ(memory.attach(driver::ring::shared_name(name_).c_str()), driver::ring::Memory::Found::ring);
  memory.header().written.fetch_add(kSlots + 1);
  EXPECT_TRUE(read(*device).empty());
  EXPECT_EQ(device->counters().bad, 1U);
  write(writer, 3, 1);  // the writer's own count is right
  EXPECT_TRUE(read(*device).empty());
  EXPECT_EQ(device->counters().bad, 2U);
  write(writer, 4, 2);
  EXPECT_EQ(read(*device), range(4, 5));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 5, .missing = 1, .bad = 2, .resynchronized = 1}));
}

TEST_F(Ring, EveryPacketWakesAReaderThatSleeps) {
  driver::RingWriter writer(name_, kSlots);
  driver::ring::Memory memory;
  ASSERT_EQ(memory.attach(driver::ring::shared_name(name_).c_str()), driver::ring::Memory::Found::ring);
  std::uint32_t woken = memory.header().wake;
  for (int i = 0; i < 6; ++i) {  // the ring is less and less empty
    const bool sleeping = i % 3 != 2;
    memory.header().sleeping = sleeping ? 1 : 0;
    write(writer, i, 1);
    woken += sleeping ? 1 : 0;
    EXPECT_EQ(memory.header().wake, woken) << "packet " << i;
  }
}

TEST_F(Ring, OneWriterOneReader) {
  EXPECT_THROW(open_ring(), UserError) << "no ring";
  driver::RingWriter writer(name_, kSlots);
  EXPECT_THROW(driver::RingWriter(name_, kSlots), UserError);
  const auto device = open_ring();
  EXPECT_THROW(open_ring(), UserError);
  EXPECT_TRUE(info().board);
  EXPECT_TRUE(info().reader);
  EXPECT_EQ(info().board_pid, static_cast<std::uint32_t>(getpid()));
  EXPECT_TRUE(writer.has_reader());
}

TEST_F(Ring, BadNamesAndSizes) {
  for (const char* name : {"", "a/b", "..//x", "a b"}) {
    EXPECT_THROW(driver::RingWriter(name, kSlots), UserError) << name;
    EXPECT_THROW(driver::open_device(std::string("ring:") + name), UserError) << name;
  }
  for (const std::uint32_t slots : {0U, 3U, 131072U}) {
    EXPECT_THROW(driver::RingWriter(name_, slots), UserError) << slots;
  }
  EXPECT_THROW(driver::remove_ring("a/b"), UserError);
  EXPECT_THROW(driver::RingWriter::deep_slots("a/b"), UserError);
}

TEST_F(Ring, NamesUpToTheirLimits) {
  for (const std::string& name : {std::string("a"), std::string("9_-.Z"), std::string(64, 'x')}) {
    EXPECT_TRUE(driver::ring::is_name(name)) << name;
  }
  for (const std::string& name : {std::string(), std::string(65, 'x'), std::string("a/"), std::string("\xE4")}) {
    EXPECT_FALSE(driver::ring::is_name(name)) << name;
  }
}

TEST_F(Ring, OfAnotherLayout) {
  const std::string shared = driver::ring::shared_name(name_);
  { driver::RingWriter writer(name_, kSlots); }
  {
    driver::ring::Memory memory;
    memory.attach(shared.c_str());
    memory.header().spec_hash ^= 1;
  }
  EXPECT_THROW(open_ring(), UserError);
  EXPECT_NE(info().problem, "");
  driver::RingWriter writer(name_, kSlots);  // replaces it
  EXPECT_EQ(info().problem, "");
}

// The beginning of a ring as a test may write it. Nothing but this header takes memory.
struct Layout {
  std::uint64_t magic = driver::ring::kMagic;
  std::uint32_t version = driver::ring::kVersion;
  std::uint32_t spec_hash = spec::kHash;
  std::uint32_t slots = kSlots;
  std::uint32_t slot_bytes = driver::ring::kSlotBytes;
};

void make_by_hand(const std::string& name, const Layout& layout, std::size_t more_bytes = 0) {
  const int file = shm_open(driver::ring::shared_name(name).c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const std::size_t bytes = driver::ring::ring_bytes(layout.slots) + more_bytes;
  ASSERT_EQ(ftruncate(file, static_cast<off_t>(bytes)), 0);
  ASSERT_EQ(pwrite(file, &layout, sizeof layout, 0), static_cast<ssize_t>(sizeof layout));
  close(file);
}

// Each field alone makes it a ring that nobody can use, and a board replaces.
TEST_F(Ring, EachFieldOfTheLayoutCounts) {
  struct Wrong {
    const char* what;
    Layout layout;
    std::size_t more_bytes = 0;
  };
  for (const Wrong& wrong :
       {Wrong{"version", {.version = driver::ring::kVersion + 1}},
        Wrong{"specification", {.spec_hash = spec::kHash + 1}}, Wrong{"slots", {.slots = 12}},
        Wrong{"too many slots", {.slots = 2 * driver::ring::kMaxSlots}},
        Wrong{"size of a slot", {.slot_bytes = driver::ring::kSlotBytes - 64}}, Wrong{"size", {}, 64}}) {
    SCOPED_TRACE(wrong.what);
    make_by_hand(name_, wrong.layout, wrong.more_bytes);
    EXPECT_EQ(error_of([&] { open_ring(); }), "ring:" + name_ + ": is a ring of another version or specification");
    EXPECT_THROW(static_cast<void>(open_patient()), UserError);
    EXPECT_EQ(info().problem, "another version or specification");
    const driver::RingWriter writer(name_, kSlots);
    EXPECT_EQ(info().problem, "");
    EXPECT_EQ(info().slots, kSlots);
  }
  make_by_hand(name_, {.slots = driver::ring::kMaxSlots});
  EXPECT_EQ(info().slots, driver::ring::kMaxSlots);
}

// A ring with as many slots as a ring of its own keeps them; the free memory is shared with the rest of the machine.
TEST_F(Ring, TheDepthOfARing) {
  for (const std::uint32_t there : {1024U, 4096U, 65536U}) {
    make_by_hand(name_, {.slots = there});
    EXPECT_EQ(driver::RingWriter::deep_slots(name_), there);
  }
  struct statvfs room {};
  ASSERT_EQ(statvfs("/dev/shm", &room), 0);
  std::uint32_t fits = 16384;
  while (fits > 1024 && driver::ring::ring_bytes(fits) > room.f_bavail * room.f_frsize / 2) {
    fits /= 2;
  }
  make_by_hand(name_, {.slots = 512});
  EXPECT_EQ(driver::RingWriter::deep_slots(name_), fits) << "a shallow one is replaced";
  driver::remove_ring(name_);
  EXPECT_EQ(driver::RingWriter::deep_slots(name_), fits);
}

// A board has the lock of a file that is no ring yet, whatever its size.
TEST_F(Ring, BeingMade) {
  for (const std::size_t size : {std::size_t{0}, driver::ring::ring_bytes(kSlots)}) {
    const int file = shm_open(driver::ring::shared_name(name_).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    ASSERT_EQ(ftruncate(file, static_cast<off_t>(size)), 0);
    struct flock lock {};
    lock.l_type = F_WRLCK;
    lock.l_len = 1;
    ASSERT_EQ(fcntl(file, F_OFD_SETLK, &lock), 0);
    EXPECT_EQ(info().problem, "a board is making it");
    model::PacketView packet;
    EXPECT_EQ(open_ring()->next(packet, nanoseconds(0)), driver::Next::timeout);
    close(file);
    EXPECT_EQ(info().problem, "not complete");
  }
}

TEST_F(Ring, WhatTheListSays) {
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, 3);
  {
    const auto device = open_ring();
    EXPECT_EQ(read(*device), range(0, 2));
    EXPECT_EQ(writer.unread(), 0U);
    write(writer, 3, kSlots + 5);
    EXPECT_EQ(writer.unread(), kSlots);
    const driver::RingInfo now = info();
    EXPECT_EQ(now.slots, kSlots);
    EXPECT_EQ(now.written, kSlots + 3);
    EXPECT_EQ(now.read, 3U);
    EXPECT_EQ(now.lost, 5U);
    EXPECT_EQ(now.boards, 1U);
    EXPECT_EQ(now.readers, 1U);
    EXPECT_EQ(now.board_crashes + now.reader_crashes, 0U);
  }
  { const auto device = open_ring(); }
  EXPECT_EQ(info().readers, 2U);
  EXPECT_EQ(info().boards, 1U);
  EXPECT_FALSE(info().reader);
  EXPECT_EQ(info().reader_crashes, 0U);
}

TEST_F(Ring, TheListIsSortedAndHasRingsOnly) {
  const driver::RingWriter b(name_ + "-b", kSlots);
  const driver::RingWriter a(name_ + "-a", kSlots);
  const driver::RingWriter c(name_ + "-c", kSlots);
  const std::vector<std::string> others = {"/selfproj-ring-" + name_ + " d", "/selfproj_ring_" + name_ + "-e"};
  for (const std::string& other : others) {
    close(shm_open(other.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  }
  std::vector<std::string> mine;
  for (const driver::RingInfo& ring : driver::list_rings()) {
    if (ring.name.starts_with(name_)) {
      mine.push_back(ring.name);
    }
  }
  EXPECT_EQ(mine, (std::vector<std::string>{name_ + "-a", name_ + "-b", name_ + "-c"}));
  for (const std::string& other : others) {
    shm_unlink(other.c_str());
  }
  for (const std::string& name : mine) {
    driver::remove_ring(name);
  }
}

// The arrival is when the board wrote, however late the reader comes.
TEST_F(Ring, TheTimeOfArrival) {
  driver::RingWriter writer(name_, kSlots);
  const std::int64_t before = driver::now_ns();
  write(writer, 0, 1);
  const std::int64_t after = driver::now_ns();
  const auto device = open_ring();
  std::this_thread::sleep_for(milliseconds(1));
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, nanoseconds(0)), driver::Next::packet);
  EXPECT_GE(device->arrival_ns(), before);
  EXPECT_LE(device->arrival_ns(), after);
}

// A board that is started again goes on where the last one was: what is unread and what was lost stays.
TEST_F(Ring, ANewBoardGoesOnInAFullRing) {
  {
    driver::RingWriter writer(name_, kSlots);
    write(writer, 0, kSlots + 3);
  }
  driver::RingWriter writer(name_, kSlots);
  EXPECT_EQ(writer.lost(), 0U);
  EXPECT_EQ(writer.unread(), kSlots);
  EXPECT_FALSE(writer.write(moments_packet(100)));
  EXPECT_EQ(writer.lost(), 1U);
  EXPECT_EQ(info().lost, 4U);
  const auto device = open_ring();
  EXPECT_EQ(read(*device), range(0, kSlots - 1));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = kSlots, .lost_ring = 4}));
}

// A reader knows which board wrote what it finds; packets of one board are no change.
TEST_F(Ring, PacketsOfTwoBoardsInOneBacklog) {
  { write(*std::make_unique<driver::RingWriter>(name_, kSlots), 0, 3); }
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, 2);
  {
    const auto device = open_ring();
    EXPECT_EQ(read(*device), (std::vector<std::uint64_t>{0, 1, 2, 0, 1}));
    EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 5, .restarts = 1, .reattached = 1}));
  }
  const auto device = open_ring();
  write(writer, 2, 2);
  EXPECT_EQ(read(*device), range(2, 3));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 2}));
}

TEST_F(Ring, ANewBoardIsNoChangeToAReaderThatComesAfterIt) {
  {
    driver::RingWriter past(name_, kSlots);
    write(past, 0, kSlots);  // every slot is of its generation
    EXPECT_EQ(read(*open_ring()).size(), kSlots);
  }
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  write(writer, 0, 1);
  EXPECT_EQ(read(*device), range(0, 0));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 1}));
}

// A reader that asks for no counts has reported the losses of before none the less.
TEST_F(Ring, LossesAreNotReportedAgainAfterAReaderThatDidNotAsk) {
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, kSlots + 7);
  EXPECT_EQ(open_ring()->counters().lost_ring, 7U);
  { const auto device = open_ring(); }
  EXPECT_EQ(open_ring()->counters().lost_ring, 0U);
}

// The losses of a ring count on in the one that takes its place.
TEST_F(Ring, LossesOfTwoRingsAddUp) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_patient();
  write(writer, 0, kSlots + 5);
  EXPECT_EQ(read(*device), range(0, kSlots - 1));
  ASSERT_TRUE(driver::remove_ring(name_));
  ASSERT_TRUE(writer.renew_if_removed());
  model::PacketView packet;
  const std::uint64_t first = kSlots + 5;
  write(writer, first, 1);
  ASSERT_EQ(device->next(packet, seconds(10)), driver::Next::packet);
  write(writer, first + 1, kSlots + 2);
  EXPECT_EQ(read(*device), range(first + 1, first + kSlots - 1));
  EXPECT_EQ(device->counters(),
            (driver::Counters{.delivered = 2 * kSlots, .lost_ring = 8, .missing = 5, .reattached = 1}));
  EXPECT_EQ(device->counters().lost_ring, 8U) << "asked twice";
}

// It was being made when the reader came, and its board has gone when it reads.
TEST_F(Ring, WrittenAndLeftBeforeTheReaderLooks) {
  const int file = shm_open(driver::ring::shared_name(name_).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_len = 1;
  ASSERT_EQ(fcntl(file, F_OFD_SETLK, &lock), 0);
  const auto device = open_ring();
  close(file);
  { write(*std::make_unique<driver::RingWriter>(name_, kSlots), 0, 3); }
  EXPECT_EQ(read(*device), range(0, 2));
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, seconds(10)), driver::Next::end);
}

// One that waits for the ring does not take it from another reader.
TEST_F(Ring, APatientReaderLeavesTheRingToTheOneThatHasIt) {
  const auto patient = open_patient();
  driver::RingWriter writer(name_, kSlots);
  auto other = open_ring();
  write(writer, 0, 2);
  EXPECT_TRUE(read(*patient).empty());
  EXPECT_EQ(info().readers, 1U);
  EXPECT_EQ(read(*other), range(0, 1));
  other.reset();
  write(writer, 2, 1);
  model::PacketView packet;
  EXPECT_EQ(patient->next(packet, seconds(10)), driver::Next::packet);
  EXPECT_EQ(packet.header.sequence, 2U);
}

// A board that ends and takes its ring with it is the end at once.
TEST_F(Ring, EndedAndRemoved) {
  auto writer = std::make_unique<driver::RingWriter>(name_, kSlots);
  const auto device = open_ring();
  write(*writer, 0, 2);
  writer.reset();
  ASSERT_TRUE(driver::remove_ring(name_));
  EXPECT_EQ(read(*device), range(0, 1));
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, milliseconds(500)), driver::Next::end);
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 2}));
}

// A board that was killed, and its ring removed, is waited for; with the next one all is well.
TEST_F(Ring, KilledRemovedAndMadeAgainInTime) {
  run_and_kill([&] {
    auto* writer = new driver::RingWriter(name_, kSlots);
    write(*writer, 0, 3);
  });
  const auto device = open_ring();
  ASSERT_TRUE(driver::remove_ring(name_));
  EXPECT_EQ(read(*device), range(0, 2));
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, milliseconds(60)), driver::Next::timeout);
  auto writer = std::make_unique<driver::RingWriter>(name_, kSlots);
  write(*writer, 3, 1);
  ASSERT_EQ(device->next(packet, seconds(10)), driver::Next::packet);
  writer.reset();
  EXPECT_EQ(device->next(packet, milliseconds(500)), driver::Next::end);
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 4, .reattached = 1}));
}

// A ring that was shortened and has no board is at its end, which counts once.
TEST_F(Ring, ShortenedWithoutABoard) {
  auto writer = std::make_unique<driver::RingWriter>(name_, kSlots);
  const auto device = open_ring();
  write(*writer, 0, 3);
  EXPECT_EQ(read(*device), range(0, 2));
  writer.reset();
  const int file = shm_open(driver::ring::shared_name(name_).c_str(), O_RDWR | O_CLOEXEC, 0);
  ASSERT_EQ(ftruncate(file, static_cast<off_t>(driver::ring::ring_bytes(kSlots / 2))), 0);
  close(file);
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, seconds(10)), driver::Next::end);
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 3, .bad = 1}));
  EXPECT_FALSE(info().reader) << "it has left it";
}

// Its reader has the old ring still, and reads it.
TEST_F(Ring, RemovedUnderAReaderNothingIsLost) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_patient();
  write(writer, 0, 5);
  ASSERT_TRUE(driver::remove_ring(name_));
  EXPECT_TRUE(writer.renew_if_removed());
  EXPECT_EQ(writer.lost(), 0U);
  EXPECT_EQ(info().lost, 0U);
  EXPECT_EQ(read(*device), range(0, 4));
}

// A longer file is no harm.
TEST_F(Ring, MadeLongerItGoesOn) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  const int file = shm_open(driver::ring::shared_name(name_).c_str(), O_RDWR | O_CLOEXEC, 0);
  ASSERT_EQ(ftruncate(file, static_cast<off_t>(driver::ring::ring_bytes(kSlots) + 4096)), 0);
  close(file);
  EXPECT_FALSE(writer.renew_if_removed());
  write(writer, 0, 2);
  EXPECT_EQ(read(*device), range(0, 1));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 2}));
}

// With its counts gone, the writer knows from its own how many were unread.
TEST_F(Ring, ShortenedToNothingLosesWhatWasUnread) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_patient();
  for (std::uint64_t round = 0; round < 2; ++round) {
    write(writer, kSlots * round, kSlots);
    EXPECT_EQ(read(*device), range(kSlots * round, kSlots * round + kSlots - 1));
  }
  write(writer, 2 * kSlots, 3);
  const int file = shm_open(driver::ring::shared_name(name_).c_str(), O_RDWR | O_CLOEXEC, 0);
  ASSERT_EQ(ftruncate(file, 0), 0);
  close(file);
  EXPECT_TRUE(writer.renew_if_removed());
  EXPECT_EQ(writer.lost(), 3U);
  EXPECT_EQ(info().lost, 3U);
}

// What guards the memory of a ring against a shortened file is free again where the ring is closed.
TEST_F(Ring, ShortenedAfterManyOpenings) {
  constexpr int kOpenings = 200;
  {
    driver::RingWriter writer(name_, kSlots);
    for (int i = 0; i < kOpenings; ++i) {
      open_ring();
    }
  }
  driver::remove_ring(name_);
  driver::RingWriter writer(name_, 16 * kSlots);  // larger, so it lies elsewhere
  write(writer, 0, 1);
  const auto device = open_ring();
  const int file = shm_open(driver::ring::shared_name(name_).c_str(), O_RDWR | O_CLOEXEC, 0);
  ASSERT_EQ(ftruncate(file, 0), 0);
  close(file);
  model::PacketView packet;
  EXPECT_NE(device->next(packet, std::chrono::milliseconds(10)), driver::Next::packet);
}

TEST_F(Ring, InterruptedWhileItWasMade) {
  const int descriptor = shm_open(driver::ring::shared_name(name_).c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(ftruncate(descriptor, 5000), 0);
  close(descriptor);
  EXPECT_THROW(open_ring(), UserError);
  EXPECT_EQ(info().problem, "not complete");
  driver::RingWriter writer(name_, kSlots);
  EXPECT_NO_THROW(open_ring());
}

TEST_F(Ring, NoRoomForIt) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{100000, before.rlim_max};
  signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(driver::RingWriter(name_, 1024), UserError);
  const std::string most = std::to_string(driver::ring::ring_bytes(65536) >> 20U) + " MiB of shared memory are needed";
  EXPECT_NE(error_of([&] { driver::RingWriter(name_, 65536); }).find(most), std::string::npos);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_EQ(info().name, "") << "nothing half made is left";
}

class RingDamage : public Ring {
 protected:
  [[nodiscard]] std::string shared() const { return driver::ring::shared_name(name_); }
  // What is removed before a reader has seen it, nobody can count.
  [[nodiscard]] bool a_reader_sees_it() const {
    for (int i = 0; i < 2000 && !info().reader; ++i) {
      std::this_thread::sleep_for(milliseconds(5));
    }
    return info().reader;
  }
  [[nodiscard]] int open_file() const { return shm_open(shared().c_str(), O_RDWR | O_CLOEXEC, 0); }
};

// A reader sees a board as long as there is one: also while the board makes the ring again, which takes time.
TEST_F(RingDamage, RenewedUnderAReaderThatEndsWithTheBoard) {
  constexpr std::uint32_t kManySlots = 4096;
  auto writer = std::make_unique<driver::RingWriter>(name_, kManySlots);
  const auto device = open_ring();
  driver::Counters counters;
  std::thread reader([&] {
    model::PacketView packet;
    while (device->next(packet, milliseconds(50)) != driver::Next::end) {
    }
    counters = device->counters();
  });
  std::uint64_t sent = 0;
  for (int round = 0; round < 8; ++round) {
    write(*writer, sent, 100);
    sent += 100;
    EXPECT_TRUE(a_reader_sees_it());
    driver::remove_ring(name_);
    std::this_thread::sleep_for(milliseconds(60));
    EXPECT_TRUE(writer->renew_if_removed());
  }
  write(*writer, sent, 100);
  sent += 100;
  EXPECT_TRUE(a_reader_sees_it());
  writer.reset();
  reader.join();
  EXPECT_EQ(counters.delivered + counters.lost_ring, sent);
  EXPECT_GE(counters.delivered, sent / 3);
}

// One that is just being made is waited for.
TEST_F(RingDamage, OpenedWhileABoardMakesIt) {
  const int file = shm_open(shared().c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_len = 1;
  ASSERT_EQ(fcntl(file, F_OFD_SETLK, &lock), 0);
  const auto device = open_ring();
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, milliseconds(100)), driver::Next::timeout);
  EXPECT_EQ(info().problem, "a board is making it");
  close(file);
  EXPECT_EQ(device->next(packet, seconds(10)), driver::Next::end) << "the making was interrupted";
}

// 10 + 54 of 1000 are read by two readers; what is lost is counted by one of them.
TEST_F(RingDamage, LossesAreCountedOnce) {
  driver::RingWriter writer(name_, 64);
  write(writer, 0, 1000);
  std::uint64_t delivered = 0;
  std::uint64_t lost = 0;
  const auto read_some = [&](std::uint64_t most) {
    const auto device = open_ring();
    model::PacketView packet;
    for (std::uint64_t i = 0; i < most && device->next(packet, nanoseconds(0)) == driver::Next::packet; ++i) {
      device->release();
    }
    delivered += device->counters().delivered;
    lost += device->counters().lost_ring;
  };
  read_some(10);
  EXPECT_EQ(delivered, 10U);
  read_some(1000);
  EXPECT_EQ(delivered, 64U);
  EXPECT_EQ(lost, 936U);
  write(writer, 1000, 70);
  read_some(1000);
  read_some(1000);
  EXPECT_EQ(delivered, 128U);
  EXPECT_EQ(lost, 942U);
}

// What a reader did not report, because it was killed, the next one does.
TEST_F(RingDamage, LossesOfAKilledReaderAreNotForgotten) {
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, kSlots + 7);
  const pid_t child = fork();
  if (child == 0) {
    const auto device = open_ring();
    static_cast<void>(device->counters());
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  const auto device = open_ring();
  EXPECT_EQ(read(*device), range(0, kSlots - 1));
  EXPECT_EQ(device->counters().lost_ring, 7U);
}

// Counts that cannot be, found when a reader begins: it says so, and goes on with what comes.
TEST_F(RingDamage, DamagedCountsAtTheBeginning) {
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, 5);
  driver::ring::Memory memory;
  ASSERT_EQ(memory.attach(shared().c_str()), driver::ring::Memory::Found::ring);
  memory.header().read.store(1000);
  const auto device = open_ring();
  EXPECT_TRUE(read(*device).empty());
  EXPECT_EQ(device->counters().bad, 1U);
  write(writer, 5, 2);
  EXPECT_EQ(read(*device), range(5, 6));
  EXPECT_EQ(device->counters().resynchronized, 1U);
}

TEST_F(RingDamage, ALossThatCannotBe) {
  driver::RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  driver::ring::Memory memory;
  ASSERT_EQ(memory.attach(shared().c_str()), driver::ring::Memory::Found::ring);
  memory.header().lost.store(UINT64_MAX);
  EXPECT_EQ(device->counters().lost_ring, 0U);
  EXPECT_EQ(device->counters().bad, 1U);
}

// The same frame number and time from another writer is another frame.
TEST_F(RingDamage, TheFirstPacketOfANewBoardIsNoRepetition) {
  const auto device = open_patient();
  { driver::RingWriter(name_, kSlots).write(moments_packet(0)); }
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, seconds(10)), driver::Next::packet);
  device->release();
  driver::RingWriter writer(name_, kSlots);
  write(writer, 0, 2);
  EXPECT_EQ(read(*device), range(0, 1));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 3, .restarts = 1, .reattached = 1}));
}

// A ring that fits but cannot be mapped stays what it is, with what is in it.
TEST_F(RingDamage, WithoutAddressSpaceNothingIsDestroyed) {
  { write(*std::make_unique<driver::RingWriter>(name_, kSlots), 0, 10); }
  const pid_t child = fork();
  if (child == 0) {
    // room for half a ring beside what this process has already: the sanitizers need a little more for themselves
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const auto has = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    const rlimit little{has + driver::ring::ring_bytes(kSlots) / 2, RLIM_INFINITY};
    setrlimit(RLIMIT_AS, &little);
    try {
      const driver::RingWriter writer(name_, kSlots);
    } catch (const UserError&) {
      _exit(0);
    }
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(read(*open_ring()), range(0, 9));
}

// Another process makes the file shorter under both: no signal, and what is lost is counted.
TEST_F(RingDamage, MadeShorterUnderBoth) {
  for (const off_t size : {off_t{0}, off_t{100}, static_cast<off_t>(driver::ring::ring_bytes(kSlots / 2))}) {
    driver::RingWriter writer(name_, kSlots);
    const auto device = open_patient();
    write(writer, 0, 4);
    EXPECT_EQ(read(*device), range(0, 3));
    write(writer, 4, 6);
    const int file = open_file();
    ASSERT_EQ(ftruncate(file, size), 0);
    close(file);
    write(writer, 10, 2);
    EXPECT_TRUE(writer.renew_if_removed());
    write(writer, 12, 3);
    model::PacketView packet;
    std::uint64_t last = 0;
    const auto end = std::chrono::steady_clock::now() + seconds(10);
    while (last != 14 && std::chrono::steady_clock::now() < end) {
      if (device->next(packet, milliseconds(50)) == driver::Next::packet) {
        last = packet.header.sequence;
      }
    }
    EXPECT_EQ(last, 14U) << size;
    const driver::Counters counters = device->counters();
    EXPECT_GE(counters.delivered + counters.lost_ring, 15U) << size;
    EXPECT_GT(counters.bad + counters.lost_ring, 0U) << size;
    driver::remove_ring(name_);
  }
}

// Runs as somebody else, who may not remove files of /dev/shm. Returns the status.
int status_as_nobody(const std::function<int()>& what) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(10);
    _exit(setgid(65534) == 0 && setuid(65534) == 0 ? what() : 99);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

// Where a ring of another size may not be taken away, the writer says so, and does not try for ever.
TEST_F(RingDamage, AnotherOnesRingCannotBeReplaced) {
  if (geteuid() != 0) {
    GTEST_SKIP() << "only root can give a ring to someone else";
  }
  { driver::RingWriter writer(name_, 2 * kSlots); }
  const int file = open_file();
  ASSERT_EQ(fchmod(file, 0666), 0);
  close(file);
  EXPECT_EQ(status_as_nobody([&] {
              try {
                const driver::RingWriter writer(name_, kSlots);
              } catch (const UserError& error) {
                return std::string(error.what()).find("which cannot be replaced: ") != std::string::npos ? 0 : 1;
              }
              return 2;
            }),
            0);
  EXPECT_EQ(info().slots, 2 * kSlots);
}

// A reader that may not write into the ring is told what it needs.
TEST_F(RingDamage, AReaderNeedsTheRightToWrite) {
  if (geteuid() != 0) {
    GTEST_SKIP() << "only root can give a ring to someone else";
  }
  const driver::RingWriter writer(name_, kSlots);
  const int file = open_file();
  ASSERT_EQ(fchmod(file, 0644), 0);
  close(file);
  EXPECT_EQ(status_as_nobody([&] {
              try {
                static_cast<void>(open_ring());
              } catch (const UserError& error) {
                return std::string(error.what()).find("needs the right to write") != std::string::npos ? 0 : 1;
              }
              return 2;
            }),
            0);
}

// To look at a ring needs no right to write; without any right it says so, and nobody removes another one's ring.
TEST_F(RingDamage, WhatAStrangerMayDo) {
  if (geteuid() != 0) {
    GTEST_SKIP() << "only root can give a ring to someone else";
  }
  const driver::RingWriter writer(name_, kSlots);
  for (const unsigned mode : {0644U, 0600U}) {
    const int file = open_file();
    ASSERT_EQ(fchmod(file, mode), 0);
    close(file);
    EXPECT_EQ(status_as_nobody([&] {
                const driver::RingInfo there = info();
                const std::string problem = mode == 0600U ? files::error_text(EACCES) : "";
                const bool told = there.problem == problem && there.slots == (mode == 0600U ? 0U : kSlots);
                return told && error_of([&] { driver::remove_ring(name_); }) != "none" ? 0 : 1;
              }),
              0)
        << mode;
  }
  EXPECT_EQ(info().slots, kSlots);
}

// A bus error that no ring has made ends the program, as ever.
TEST_F(RingDamage, OtherBusErrorsActAsUsual) {
  const driver::RingWriter writer(name_, kSlots);
  const pid_t child = fork();
  if (child == 0) {
    alarm(10);
    const int file = memfd_create("other", MFD_CLOEXEC);
    static_cast<void>(ftruncate(file, 4096));
    auto* const bytes = static_cast<volatile char*>(mmap(nullptr, 4096, PROT_READ, MAP_SHARED, file, 0));
    static_cast<void>(ftruncate(file, 0));
    _exit(bytes[0]);
  }
  int status = 0;
  waitpid(child, &status, 0);
#ifdef __SANITIZE_ADDRESS__  // it has an action of its own, which is called
  EXPECT_NE(status, 0);
#else
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGBUS) << status;
#endif
}

}  // namespace
}  // namespace selfproj::test
