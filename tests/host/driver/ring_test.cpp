// The ring in shared memory: whatever happens to its writer, its reader or itself is counted, and what is read is
// right.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "host/driver/open_device.h"
#include "host/driver/packet_limits.h"
#include "host/driver/ring_layout.h"
#include "host/driver/ring_list.h"
#include "host/driver/ring_memory.h"
#include "host/driver/ring_writer.h"
#include "host/io/user_error.h"
#include "tests/host/driver/packets.h"

namespace {
std::atomic<std::uint64_t> allocations{0};
}

// Counts what is allocated, for the test that nothing is. Kept out of line, so that the compiler does not pair the free
// below with an operator new that it knows.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size); memory != nullptr) {
    return memory;
  }
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace selfproj::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr std::uint32_t kSlots = 16;

// A ring name of its own for every test, gone at its end.
class Ring : public ::testing::Test {
 protected:
  void SetUp() override { remove_ring(name_); }
  void TearDown() override { remove_ring(name_); }

  [[nodiscard]] std::unique_ptr<Device> open_ring(DeviceOptions options = {}) const {
    return open_device("ring:" + name_, options);
  }

  // A reader that does not mind the board's absence.
  [[nodiscard]] std::unique_ptr<Device> open_patient() const { return open_ring({.wait_for_board = true}); }

  [[nodiscard]] RingInfo info() const {
    for (const RingInfo& ring : list_rings()) {
      if (ring.name == name_) {
        return ring;
      }
    }
    return {};
  }

  std::string name_ = "test-" + std::to_string(getpid());
};

void write(RingWriter& writer, std::uint64_t first, int count) {
  for (int i = 0; i < count; ++i) {
    writer.write(moments_packet(first + static_cast<std::uint64_t>(i)));
  }
}

// All that is there now.
std::vector<std::uint64_t> read(Device& device) {
  std::vector<std::uint64_t> sequences;
  PacketView packet;
  while (device.next(packet, nanoseconds(0)) == Next::packet) {
    EXPECT_TRUE(is_intact(packet));
    sequences.push_back(packet.header.sequence);
    device.release();
  }
  return sequences;
}

std::vector<std::uint64_t> range(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> all;
  for (std::uint64_t i = first; i <= last; ++i) {
    all.push_back(i);
  }
  return all;
}

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
  // While nobody reads, what finds the ring full is counted, and the next reader says so.
}

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
  // A count that cannot be.
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

// Writer and reader at once, as fast as they can, by each way of waiting. With back pressure nothing may be lost.
TEST_F(Ring, TwoThreads) {
  constexpr std::uint64_t kCount = 3000;
  for (const Wait wait : {Wait::polling, Wait::blocking, Wait::polling_then_blocking}) {
    RingWriter writer(name_, kSlots);
    const auto device = open_ring({.wait = wait});
    std::thread board([&] {
      for (std::uint64_t i = 0; i < kCount; ++i) {
        while (writer.unread() >= kSlots) {
          std::this_thread::yield();
        }
        writer.write(moments_packet(i));
      }
    });
    PacketView packet;
    std::uint64_t expected = 0;
    while (expected < kCount && device->next(packet, seconds(10)) == Next::packet) {
      ASSERT_EQ(packet.header.sequence, expected++);
      ASSERT_TRUE(is_intact(packet));
      device->release();
    }
    board.join();
    EXPECT_EQ(device->counters(), (Counters{.delivered = kCount}));
  }
}

// The same without back pressure and with a reader that dawdles: what is lost is counted to the last packet.
TEST_F(Ring, TwoThreadsWithLosses) {
  constexpr std::uint64_t kCount = 50000;
  const auto device = open_patient();
  std::thread board([&] {
    RingWriter writer(name_, kSlots);
    for (std::uint64_t i = 0; i < kCount; ++i) {
      writer.write(moments_packet(i, 4));
    }
    while (!writer.write(moments_packet(kCount, 4))) {  // so that the last gap is seen
      std::this_thread::sleep_for(milliseconds(1));
    }
  });
  PacketView packet;
  Random random(1);
  std::uint64_t last = 0;
  while (last < kCount && device->next(packet, seconds(10)) == Next::packet) {
    ASSERT_TRUE(is_intact(packet));
    last = packet.header.sequence;
    if (random.chance(2)) {
      std::this_thread::sleep_for(std::chrono::microseconds(random.between(1, 300)));
    }
  }
  board.join();
  const Counters counters = device->counters();
  EXPECT_EQ(counters.bad, 0U);
  EXPECT_LE(counters.delivered + counters.missing, kCount + 1);
  EXPECT_EQ(counters.delivered + counters.lost_ring, kCount + 1 + (counters.lost_ring - counters.missing));
}

// 10^4 times a reader and a board come and go: what is read is whole, in order, and all that was written.
TEST_F(Ring, TenThousandStartsAndStops) {
  Random random(1);
  auto writer = std::make_unique<RingWriter>(name_, kSlots);
  PacketView packet;
  std::uint64_t written = 0;
  std::uint64_t expected = 0;
  for (int i = 0; i < 10000; ++i) {
    const int count = random.between(0, 5);
    write(*writer, written, count);
    written += static_cast<std::uint64_t>(count);
    if (random.chance(20)) {
      writer.reset();
      writer = std::make_unique<RingWriter>(name_, kSlots);
    }
    const auto device = open_ring();
    for (int reads = random.between(written - expected > 10 ? 5 : 0, 6);
         reads > 0 && device->next(packet, nanoseconds(0)) == Next::packet; --reads) {
      ASSERT_TRUE(is_intact(packet));
      ASSERT_EQ(packet.header.sequence, expected++) << "start " << i;
      if (random.chance(50)) {
        device->release();  // otherwise closed with the packet in hand: it counts as read
      }
    }
    ASSERT_EQ(device->counters().bad + device->counters().lost_ring, 0U);
  }
  EXPECT_EQ(info().reader_crashes + info().board_crashes, 0U);
  EXPECT_EQ(info().readers, 10000U);
}

// The same while the board writes on in its own time.
TEST_F(Ring, ReadersComeAndGoWhileTheBoardWrites) {
  RingWriter writer(name_, kSlots);
  std::atomic<bool> stop{false};
  std::thread board([&] {
    for (std::uint64_t i = 0; !stop; ++i) {
      writer.write(moments_packet(i));
    }
  });
  std::uint64_t next_sequence = 0;
  PacketView packet;
  for (int i = 0; i < 300; ++i) {
    const auto device = open_ring({.discard_backlog = i % 2 == 0});
    for (int k = 0; k < 3 && device->next(packet, seconds(10)) == Next::packet; ++k) {
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

TEST_F(Ring, AllocatesNothingAfterTheStart) {
  RingWriter writer(name_, kSlots);
  const auto device = open_patient();
  const Bytes one = moments_packet(0);
  const Bytes two = moments_packet(1);
  PacketView packet;
  const std::uint64_t before = allocations;
  for (int i = 0; i < 1000; ++i) {
    writer.write(one);
    writer.write(two);
    device->next(packet, nanoseconds(0));
    device->next(packet, nanoseconds(0));
    device->next(packet, nanoseconds(1000));
    device->release();
    static_cast<void>(device->counters());
  }
  EXPECT_EQ(allocations, before);
}

}  // namespace
}  // namespace selfproj::test
