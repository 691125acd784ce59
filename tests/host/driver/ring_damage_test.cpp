// Rings under attack: damaged, renewed, refused, made shorter. Every packet is delivered or counted, once.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

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

class RingDamage : public Ring {
 protected:
  [[nodiscard]] std::string shared() const { return ring::shared_name(name_); }
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
  auto writer = std::make_unique<RingWriter>(name_, kManySlots);
  const auto device = open_ring();
  Counters counters;
  std::thread reader([&] {
    PacketView packet;
    while (device->next(packet, milliseconds(50)) != Next::end) {
    }
    counters = device->counters();
  });
  std::uint64_t sent = 0;
  for (int round = 0; round < 8; ++round) {
    write(*writer, sent, 100);
    sent += 100;
    EXPECT_TRUE(a_reader_sees_it());
    remove_ring(name_);
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
  PacketView packet;
  EXPECT_EQ(device->next(packet, milliseconds(100)), Next::timeout);
  EXPECT_EQ(info().problem, "a board is making it");
  close(file);
  EXPECT_EQ(device->next(packet, seconds(10)), Next::end) << "the making was interrupted";
}

// 10 + 54 of 1000 are read by two readers; what is lost is counted by one of them.
TEST_F(RingDamage, LossesAreCountedOnce) {
  RingWriter writer(name_, 64);
  write(writer, 0, 1000);
  std::uint64_t delivered = 0;
  std::uint64_t lost = 0;
  const auto read_some = [&](std::uint64_t most) {
    const auto device = open_ring();
    PacketView packet;
    for (std::uint64_t i = 0; i < most && device->next(packet, nanoseconds(0)) == Next::packet; ++i) {
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

// What a reader did not tell of, because it was killed, the next one does.
TEST_F(RingDamage, LossesOfAKilledReaderAreNotForgotten) {
  RingWriter writer(name_, kSlots);
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
  RingWriter writer(name_, kSlots);
  write(writer, 0, 5);
  ring::Memory memory;
  ASSERT_EQ(memory.attach(shared().c_str()), ring::Memory::Found::ring);
  memory.header().read.store(1000);
  const auto device = open_ring();
  EXPECT_TRUE(read(*device).empty());
  EXPECT_EQ(device->counters().bad, 1U);
  write(writer, 5, 2);
  EXPECT_EQ(read(*device), range(5, 6));
  EXPECT_EQ(device->counters().resynchronized, 1U);
}

TEST_F(RingDamage, ALossThatCannotBe) {
  RingWriter writer(name_, kSlots);
  const auto device = open_ring();
  ring::Memory memory;
  ASSERT_EQ(memory.attach(shared().c_str()), ring::Memory::Found::ring);
  memory.header().lost.store(UINT64_MAX);
  EXPECT_EQ(device->counters().lost_ring, 0U);
  EXPECT_EQ(device->counters().bad, 1U);
}

// The same frame number and time from another writer is another frame.
TEST_F(RingDamage, TheFirstPacketOfANewBoardIsNoRepetition) {
  const auto device = open_patient();
  { RingWriter(name_, kSlots).write(moments_packet(0)); }
  PacketView packet;
  ASSERT_EQ(device->next(packet, seconds(10)), Next::packet);
  device->release();
  RingWriter writer(name_, kSlots);
  write(writer, 0, 2);
  EXPECT_EQ(read(*device), range(0, 1));
  EXPECT_EQ(device->counters(), (Counters{.delivered = 3, .restarts = 1, .reattached = 1}));
}

// A ring that fits but cannot be mapped stays what it is, with what is in it.
TEST_F(RingDamage, WithoutAddressSpaceNothingIsDestroyed) {
  { write(*std::make_unique<RingWriter>(name_, kSlots), 0, 10); }
  const pid_t child = fork();
  if (child == 0) {
    // room for half a ring beside what this process has already: the sanitizers need a little more for themselves
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const auto has = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    const rlimit little{has + ring::ring_bytes(kSlots) / 2, RLIM_INFINITY};
    setrlimit(RLIMIT_AS, &little);
    try {
      const RingWriter writer(name_, kSlots);
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
  for (const off_t size : {off_t{0}, off_t{100}, static_cast<off_t>(ring::ring_bytes(kSlots / 2))}) {
    RingWriter writer(name_, kSlots);
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
    PacketView packet;
    std::uint64_t last = 0;
    const auto end = std::chrono::steady_clock::now() + seconds(10);
    while (last != 14 && std::chrono::steady_clock::now() < end) {
      if (device->next(packet, milliseconds(50)) == Next::packet) {
        last = packet.header.sequence;
      }
    }
    EXPECT_EQ(last, 14U) << size;
    const Counters counters = device->counters();
    EXPECT_GE(counters.delivered + counters.lost_ring, 15U) << size;
    EXPECT_GT(counters.bad + counters.lost_ring, 0U) << size;
    remove_ring(name_);
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
  { RingWriter writer(name_, 2 * kSlots); }
  const int file = open_file();
  ASSERT_EQ(fchmod(file, 0666), 0);
  close(file);
  EXPECT_EQ(status_as_nobody([&] {
              try {
                const RingWriter writer(name_, kSlots);
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
  const RingWriter writer(name_, kSlots);
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

}  // namespace
}  // namespace selfproj::test
