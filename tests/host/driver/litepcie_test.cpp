// Tests boards behind LitePCIe's driver through the seam: packets out of a ring that the DMA writes over, and
// registers.
#include "host/driver/litepcie.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "host/driver/boards.h"
#include "host/driver/clock.h"
#include "host/driver/control.h"
#include "host/driver/litepcie_interface.h"
#include "host/files/file_descriptor.h"
#include "selfproj/driver/device.h"
#include "tests/cli/program.h"
#include "tests/host/driver/packets.h"
#include "tests/support/board_registers.h"
#include "tests/support/error_of.h"
#include "tests/support/litepcie_player.h"

namespace selfproj::test {
namespace {

constexpr std::chrono::nanoseconds kOnce{0};
constexpr const char* kUri = "litepcie:/dev/litepcie0";

std::unique_ptr<driver::Device> open(LitePciePlayer& player, const driver::DeviceOptions& options = {}) {
  return driver::make_litepcie_device(std::make_unique<LitePciePlayerPort>(player), kUri, options);
}

// Reads what is there. Every packet must be whole, and later than the one before.
struct Reading {
  std::uint64_t packets = 0;
  std::uint64_t newest = 0;

  void read(driver::Device& device) {
    model::PacketView packet;
    while (device.next(packet, kOnce) == driver::Next::packet) {
      ASSERT_TRUE(is_intact(packet)) << packet.header.sequence;
      ASSERT_TRUE(packets == 0 || packet.header.sequence > newest) << packet.header.sequence;
      newest = packet.header.sequence;
      ++packets;
    }
  }
};

TEST(LitePcieDevice, EveryPacketThroughManyRounds) {
  LitePciePlayer player(16, 8192);
  const std::unique_ptr<driver::Device> device = open(player);
  Reading reading;
  for (std::uint64_t first = 0; first < 2000; first += 10) {
    ASSERT_TRUE(player.write(moments_stream(first, 10, 512)));  // 10 x 4176 bytes: five buffers
    reading.read(*device);
  }
  EXPECT_GT(player.finished(), 60 * 16U);
  // The newest finished buffer is not seen before the next one is finished, too.
  EXPECT_LT(reading.packets, 2000U);
  player.fill();
  reading.read(*device);
  EXPECT_EQ(reading.packets, 2000U);
  driver::Counters want;
  want.delivered = 2000;
  EXPECT_EQ(device->counters(), want);
}

TEST(LitePcieDevice, ZerosBehindBursts) {
  LitePciePlayer player(8, 256);
  const std::unique_ptr<driver::Device> device = open(player);
  Reading reading;
  std::uint64_t sent = 0;
  for (int burst = 1; burst < 40; ++burst) {
    ASSERT_TRUE(player.write(moments_stream(sent, burst % 3 + 1, 4 * (burst % 5 + 1))));
    sent += static_cast<std::uint64_t>(burst % 3 + 1);
    player.fill();
    reading.read(*device);
    EXPECT_EQ(reading.packets, sent);
  }
  driver::Counters want;
  want.delivered = sent;
  EXPECT_EQ(device->counters(), want);
}

TEST(LitePcieDevice, TheDmaHasComeRound) {
  LitePciePlayer player(8, 1024);
  const std::unique_ptr<driver::Device> device = open(player);
  Reading reading;
  ASSERT_TRUE(player.write(moments_stream(0, 10)));
  player.fill();
  reading.read(*device);
  ASSERT_EQ(reading.packets, 10U);
  ASSERT_TRUE(player.write(moments_stream(10, 300)));  // 300 x 208 bytes: seven rounds
  player.fill();
  reading.read(*device);
  const driver::Counters counters = device->counters();
  EXPECT_EQ(counters.read_errors, 1U);
  EXPECT_EQ(counters.resynchronized, 1U);
  EXPECT_GT(counters.missing, 0U);
  EXPECT_EQ(reading.newest, 309U);
  EXPECT_EQ(counters.delivered + counters.missing, 310U);
  EXPECT_GE(counters.bytes_discarded, counters.missing * moments_packet(0).size());
  // What comes after it is whole again.
  ASSERT_TRUE(player.write(moments_stream(310, 5)));
  player.fill();
  reading.read(*device);
  EXPECT_EQ(reading.newest, 314U);
  EXPECT_EQ(device->counters().missing, counters.missing);
}

// The DMA is in the middle of a buffer, and so many are finished that the reader has not seen: all of them come, or the
// oldest are lost and counted. None is read while it is written over.
TEST(LitePcieDevice, BehindByAnyNumberOfBuffers) {
  constexpr std::size_t kBuffers = 8;
  constexpr std::size_t kBytes = 1024;
  constexpr std::uint64_t kPackets = 200;  // 40 buffers
  const std::vector<std::uint8_t> stream = moments_stream(0, kPackets);
  for (std::size_t behind = 0; behind <= 2 * kBuffers; ++behind) {
    for (const std::size_t place : {std::size_t{0}, std::size_t{208}, kBytes / 2, kBytes - 16}) {
      SCOPED_TRACE(std::to_string(behind) + " buffers and " + std::to_string(place) + " bytes");
      LitePciePlayer player(kBuffers, kBytes);
      const std::unique_ptr<driver::Device> device = open(player);
      const std::span<const std::uint8_t> all(stream);
      const std::size_t first = behind * kBytes + place;
      ASSERT_TRUE(player.write(all.first(first)));
      Reading reading;
      reading.read(*device);
      for (std::size_t at = first; at < all.size(); at += kBytes) {  // from here on the reader keeps up
        ASSERT_TRUE(player.write(all.subspan(at, std::min(kBytes, all.size() - at))));
        reading.read(*device);
      }
      player.fill();
      reading.read(*device);
      const driver::Counters counters = device->counters();
      const bool lost = behind >= kBuffers;
      EXPECT_EQ(counters.bad, 0U);
      EXPECT_EQ(counters.read_errors, lost ? 1U : 0U);
      EXPECT_EQ(counters.missing > 0 || counters.delivered < kPackets, lost);
      EXPECT_EQ(reading.newest, kPackets - 1);
      ASSERT_FALSE(HasFailure());
    }
  }
}

TEST(LitePcieDevice, TheDmaComesRoundDuringTheCopy) {
  LitePciePlayer player(8, 1024);
  const std::unique_ptr<driver::Device> device = open(player);
  ASSERT_TRUE(player.write(moments_stream(0, 20)));  // 20 x 208 bytes: four buffers
  int accesses = 0;
  player.on_access = [&] {
    if (++accesses == 2) {                   // after the copy
      player.write(moments_stream(20, 26));  // five buffers: only the last two that were copied are still whole
    }
  };
  Reading reading;
  reading.read(*device);
  EXPECT_GE(accesses, 2);
  player.fill();
  reading.read(*device);
  EXPECT_EQ(reading.newest, 45U);
  const driver::Counters counters = device->counters();
  EXPECT_EQ(counters.read_errors, 1U);
  EXPECT_LT(counters.delivered, 46U);
  EXPECT_EQ(counters.bad, 0U);
}

// The DMA writes as fast as it can while the reader reads: what comes is whole, and what does not come is counted.
TEST(LitePcieDevice, AFastBoardInAnotherThread) {
  LitePciePlayer player(32, 1024);
  const std::unique_ptr<driver::Device> device = open(player, {.wait = driver::Wait::blocking});
  constexpr std::uint64_t kPackets = 20'000;
  Reading reading;
  ASSERT_TRUE(player.write(moments_stream(0, 4)));  // so that the first packet is known, whenever the thread runs
  player.fill();
  reading.read(*device);
  std::atomic<bool> done = false;
  std::thread board([&] {
    for (std::uint64_t first = 4; first < kPackets; first += 4) {
      player.write(moments_stream(first, 4, 16));
    }
    player.fill();
    done = true;
  });
  while (!done) {
    reading.read(*device);
  }
  board.join();
  reading.read(*device);
  const driver::Counters counters = device->counters();
  EXPECT_EQ(reading.newest, kPackets - 1);
  EXPECT_EQ(counters.delivered, reading.packets);
  EXPECT_EQ(counters.delivered + counters.missing, kPackets);
  EXPECT_EQ(counters.missing == 0, counters.read_errors == 0);
}

// The register of the loop has 16 bits for the rounds.
TEST(LitePcieDevice, TheRegisterWraps) {
  LitePciePlayer player(4, 16);
  const std::unique_ptr<driver::Device> device = open(player);
  Reading reading;
  std::uint64_t sent = 0;
  while (player.finished() < 5 * 65536) {
    const Bytes next = moments_packet(sent++, 4);
    for (std::size_t at = 0; at < next.size(); at += 16) {
      ASSERT_TRUE(player.write(std::span(next).subspan(at, 16)));
      reading.read(*device);
    }
  }
  EXPECT_GE(reading.packets + 1, sent);
  EXPECT_EQ(device->counters().read_errors, 0U);
  EXPECT_EQ(device->counters().reattached, 0U);
}

TEST(LitePcieDevice, ABoardThatIsReset) {
  LitePciePlayer player(8, 1024);
  const std::unique_ptr<driver::Device> device = open(player);
  Reading reading;
  ASSERT_TRUE(player.write(moments_stream(0, 20)));
  reading.read(*device);
  ASSERT_GT(reading.packets, 0U);
  player.reset();
  EXPECT_FALSE(player.write(moments_stream(20, 1)));
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, kOnce), driver::Next::timeout);
  EXPECT_EQ(device->counters().reattached, 1U);
  ASSERT_TRUE(player.write(moments_stream(40, 5)));
  player.fill();
  reading.read(*device);
  EXPECT_EQ(reading.newest, 44U);
}

// A board that begins anew may begin with what it sent last: that is no repetition. What was begun is discarded.
TEST(LitePcieDevice, AResetInAPacket) {
  LitePciePlayer player(8, 256);
  const std::unique_ptr<driver::Device> device = open(player);
  Reading reading;
  ASSERT_TRUE(player.write(moments_stream(0, 1)));
  player.fill();
  const Bytes cut = moments_packet(1);
  ASSERT_TRUE(player.write(std::span(cut).first(160)));
  ASSERT_TRUE(player.write(Bytes(256, 7)));  // never seen: the newest buffer is not known to be finished
  const std::int64_t before = driver::now_ns();
  reading.read(*device);
  ASSERT_EQ(reading.packets, 1U);
  EXPECT_GE(device->arrival_ns(), before);
  EXPECT_LE(device->arrival_ns(), driver::now_ns());
  player.reset();
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, kOnce), driver::Next::timeout);
  ASSERT_TRUE(player.write(moments_stream(0, 2)));
  player.fill();
  reading = {};
  reading.read(*device);
  EXPECT_EQ(reading.packets, 2U);
  const driver::Counters counters = device->counters();
  EXPECT_EQ(counters.delivered, 3U);
  EXPECT_EQ(counters.repeated, 0U);
  EXPECT_EQ(counters.restarts, 1U);
  EXPECT_EQ(counters.reattached, 1U);
  EXPECT_EQ(counters.read_errors, 0U);
}

// With less than no time it looks once.
TEST(LitePcieDevice, LessThanNoTime) {
  LitePciePlayer player(8, 1024);
  for (const driver::Wait wait : {driver::Wait::polling, driver::Wait::blocking}) {
    const std::unique_ptr<driver::Device> device = open(player, {.wait = wait});
    model::PacketView packet;
    EXPECT_EQ(device->next(packet, std::chrono::nanoseconds(-1)), driver::Next::timeout);
    ASSERT_TRUE(player.write(moments_stream(0, 1)));
    player.fill();
    EXPECT_EQ(device->next(packet, std::chrono::nanoseconds(-1)), driver::Next::packet);
  }
}

// Between the device and the player: it sees what is asked for, and can let single requests fail.
class WatchedPort final : public driver::DevicePort {
 public:
  struct Watch {
    unsigned long fails = 0;  // the request that fails
    bool maps = true;
    std::int64_t read = -1;  // the last count of buffers read
    std::chrono::nanoseconds longest{0};
  };
  WatchedPort(LitePciePlayer& player, Watch& watch) : port_(player), watch_(watch) {}

  int control(unsigned long request, void* argument) override {
    if (request == driver::litepcie::kRead) {
      watch_.read = static_cast<driver::litepcie::Read*>(argument)->sw_count;
    }
    return request == watch_.fails ? EPERM : port_.control(request, argument);
  }
  const std::uint8_t* map(std::size_t bytes, std::int64_t offset) override {
    errno = ENOMEM;
    return watch_.maps ? port_.map(bytes, offset) : nullptr;
  }
  bool wait(std::chrono::nanoseconds timeout) override {
    watch_.longest = std::max(watch_.longest, timeout);
    return port_.wait(timeout);
  }

 private:
  LitePciePlayerPort port_;
  Watch& watch_;
};

TEST(LitePcieDevice, ASleepingReaderTellsHowFarItIs) {
  LitePciePlayer player(8, 1024);
  WatchedPort::Watch watch;
  const auto device = driver::make_litepcie_device(std::make_unique<WatchedPort>(player, watch), kUri,
                                                   {.wait = driver::Wait::blocking});
  ASSERT_TRUE(player.write(moments_stream(0, 15)));  // three buffers, of which two are known to be finished
  model::PacketView packet;
  while (device->next(packet, std::chrono::microseconds(300)) == driver::Next::packet) {
  }
  EXPECT_EQ(watch.read, 2);
  EXPECT_LE(watch.longest, std::chrono::microseconds(200));
  EXPECT_GT(watch.longest.count(), 0);
  watch.fails = driver::litepcie::kRead;
  EXPECT_EQ(error_of([&] { device->next(packet, std::chrono::seconds(1)); }),
            std::string(kUri) + ": its DMA does not answer: " + files::error_text(EPERM));
}

// Each request that fails is told; and nothing that was taken stays so.
TEST(LitePcieDevice, RequestsThatFail) {
  for (const auto& [request, what] : std::vector<std::pair<unsigned long, std::string>>{
           {driver::litepcie::kBuffers, "is no device of LitePCIe's driver"},
           {driver::litepcie::kLock, "its DMA cannot be taken"},
           {driver::litepcie::kDmaWriter, "its DMA cannot be stopped"}}) {
    LitePciePlayer player(8, 1024);
    WatchedPort::Watch watch{.fails = request};
    EXPECT_EQ(error_of([&] { driver::make_litepcie_device(std::make_unique<WatchedPort>(player, watch), kUri, {}); }),
              std::string(kUri) + ": " + what + ": " + files::error_text(EPERM));
    EXPECT_FALSE(player.taken);
    EXPECT_FALSE(player.enabled());
  }
  LitePciePlayer player(8, 1024);
  WatchedPort::Watch watch{.maps = false};
  EXPECT_EQ(error_of([&] { driver::make_litepcie_device(std::make_unique<WatchedPort>(player, watch), kUri, {}); }),
            std::string(kUri) + ": its buffers cannot be mapped: " + files::error_text(ENOMEM));
}

// Numbers and sizes of buffers on both sides of what this program can work with.
TEST(LitePcieDevice, BuffersOfAnySize) {
  const std::size_t largest = model::kLargestPacketBytes / spec::kPacketBeatBytes * spec::kPacketBeatBytes;
  for (const auto& [count, bytes, works] :
       std::vector<std::tuple<std::size_t, std::size_t, bool>>{{4, 16, true},
                                                               {3, 16, false},
                                                               {32768, 16, true},
                                                               {32769, 16, false},
                                                               {4, 8, false},
                                                               {4, 24, false},
                                                               {4, 0, false},
                                                               {4, largest, true},
                                                               {4, largest + 16, false}}) {
    LitePciePlayer player(count, bytes);
    EXPECT_EQ(error_of([&] { open(player); }), works ? "none"
                                                     : std::string(kUri) + ": its driver has " + std::to_string(count) +
                                                           " buffers of " + std::to_string(bytes) +
                                                           " bytes, with which this program cannot work");
  }
}

TEST(LitePcieDevice, ABoardThatHasGone) {
  model::PacketView packet;
  for (const int error : {ENODEV, EIO}) {
    LitePciePlayer player(8, 1024);
    const std::unique_ptr<driver::Device> device = open(player);
    player.error = error;
    EXPECT_EQ(error_of([&] { device->next(packet, kOnce); }),
              std::string(kUri) + ": the board has gone: " + files::error_text(error));
  }
  LitePciePlayer player(8, 1024);
  const std::unique_ptr<driver::Device> device = open(player);
  player.ones = true;
  EXPECT_EQ(error_of([&] { device->next(packet, kOnce); }),
            std::string(kUri) + ": the board has gone: its registers read as ones");
}

TEST(LitePcieDevice, WhatCannotBeOpened) {
  LitePciePlayer player(8, 1024);
  {
    const std::unique_ptr<driver::Device> device = open(player);
    EXPECT_TRUE(player.enabled());
    EXPECT_EQ(error_of([&] { open(player); }), std::string(kUri) + ": already has a reader");
    EXPECT_TRUE(player.taken);
  }
  EXPECT_FALSE(player.enabled());
  EXPECT_FALSE(player.taken);
  player.foreign = true;
  EXPECT_EQ(error_of([&] { open(player); }),
            std::string(kUri) + ": is no device of LitePCIe's driver: " + files::error_text(ENOTTY));
  LitePciePlayer odd(3, 1000);
  EXPECT_NE(error_of([&] { open(odd); }).find("has 3 buffers of 1000 bytes"), std::string::npos);
  EXPECT_EQ(error_of([] { driver::open_device("litepcie:/none/litepcie0"); }),
            "litepcie:/none/litepcie0: " + files::error_text(ENOENT));
  EXPECT_EQ(error_of([] { driver::open_device("litepcie:"); }), "litepcie:: the path of the file is missing");
  EXPECT_NE(error_of([] { driver::open_device("litepcie:/dev/null"); }).find("is no device of LitePCIe's driver"),
            std::string::npos);
}

TEST(LitePcieDevice, WaitsUntilTheTimeIsUp) {
  LitePciePlayer player(8, 1024);
  const std::unique_ptr<driver::Device> device = open(player, {.wait = driver::Wait::blocking});
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, std::chrono::milliseconds(2)),
            driver::Next::timeout);  // although each wait ends at once
  EXPECT_GT(player.waits, 1U);
}

// Registers, as the driver would read them from BAR 0.
class RegisterPlayer final : public driver::DevicePort {
 public:
  RegisterPlayer(model::RegisterFile& board, const int& error) : board_(board), error_(error) {}

  int control(unsigned long request, void* argument) override {
    EXPECT_EQ(request, driver::litepcie::kAccess);
    auto& access = *static_cast<driver::litepcie::Access*>(argument);
    if (error_ != 0) {
      return error_;
    }
    const std::uint32_t address = access.address - driver::litepcie::kBoardRegisters;
    if (access.write != 0) {
      board_.write(address, access.value);
    } else {
      access.value = board_.read(address, {}).data;
    }
    return 0;
  }
  const std::uint8_t* map(std::size_t /*bytes*/, std::int64_t /*offset*/) override { return nullptr; }
  bool wait(std::chrono::nanoseconds /*timeout*/) override { return false; }

 private:
  model::RegisterFile& board_;
  const int& error_;
};

TEST(LitePciePort, RegistersOfABoard) {
  model::RegisterFile board;
  int error = 0;
  driver::Control control(driver::make_litepcie_port(std::make_unique<RegisterPlayer>(board, error), kUri));
  control.write("size.columns", 640);
  EXPECT_EQ(control.read("size.columns"), 640U);
  EXPECT_EQ(board.value(spec::kRegSize) & 0xFFFFU, 640U);
  EXPECT_NE(error_of([&] { control.write("size.columns", 6); }).find("refuses"), std::string::npos);
  const std::unique_ptr<driver::RegisterPort> port =
      driver::make_litepcie_port(std::make_unique<RegisterPlayer>(board, error), kUri);
  for (const std::uint32_t wrong : {2U, spec::kRegisters.back().address + 4}) {
    EXPECT_EQ(error_of([&] { port->write(wrong, 0); }),
              std::string(kUri) + ": has no register at " + std::to_string(wrong));
  }
  const std::uint32_t last = spec::kRegisters.back().address;
  EXPECT_EQ(port->word(last), board.read(last, {}).data);
  EXPECT_EQ(port->write(spec::kRegTimeout, 9), driver::Written::unknown);
  EXPECT_EQ(board.value(spec::kRegTimeout), 9U);
  error = ENODEV;
  EXPECT_EQ(error_of([&] { static_cast<void>(control.read("size")); }),
            std::string(kUri) + ": the board's registers cannot be reached: " + files::error_text(ENODEV));
}

TEST(LitePciePort, OpenedByItsUri) {
  EXPECT_EQ(driver::control_uri(kUri), kUri);
  EXPECT_EQ(error_of([] { driver::open_control("litepcie:/none/litepcie0"); }),
            "litepcie:/none/litepcie0: " + files::error_text(ENOENT));
  EXPECT_EQ(error_of([] { driver::open_control("litepcie:"); }), "litepcie:: the path of the file is missing");
  const ScratchFolder folder;
  write_text(folder / "litepcie0", "");
  const std::vector<driver::BoardPlace> boards = driver::list_boards(folder.path());
  ASSERT_EQ(boards.size(), 1U);
  EXPECT_EQ(boards[0].uri, "litepcie:" + (folder / "litepcie0").string());
  EXPECT_EQ(boards[0].problem, "the board's registers cannot be reached: " + files::error_text(ENOTTY));
}

}  // namespace
}  // namespace selfproj::test
