// Tests recorded streams and pipes, and the device inside a simulation.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/sim_device.h"
#include "host/files/file_descriptor.h"
#include "selfproj/driver/device.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"
#include "tests/cli/program.h"
#include "tests/host/driver/packets.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

std::string text_of(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

// Reads to the end; all packets must be intact.
std::vector<std::uint64_t> read_all(driver::Device& device) {
  std::vector<std::uint64_t> sequences;
  model::PacketView packet;
  for (;;) {
    switch (device.next(packet, milliseconds(100))) {
      case driver::Next::packet:
        EXPECT_TRUE(is_intact(packet));
        sequences.push_back(packet.header.sequence);
        device.release();
        break;
      case driver::Next::timeout:
        break;
      case driver::Next::end:
        return sequences;
    }
  }
}

TEST(FileDevice, RecordedStream) {
  const ScratchFolder folder;
  write_text(folder / "stream", text_of(moments_stream(0, 3000, 64)));
  for (const std::size_t buffer : {std::size_t{1}, std::size_t{1} << 20U}) {
    const auto device = driver::open_device("file:" + (folder / "stream").string(), {.buffer_bytes = buffer});
    EXPECT_EQ(read_all(*device).size(), 3000U);
    EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 3000}));
    EXPECT_EQ(device->uri(), "file:" + (folder / "stream").string());
  }
}

TEST(FileDevice, FaultsInARecordedStream) {
  const ScratchFolder folder;
  Bytes stream = moments_stream(0, 2);
  const Bytes cut = moments_packet(2);
  stream.insert(stream.end(), cut.begin(), cut.begin() + 70);
  append(stream, moments_packet(3));
  append(stream, moments_packet(3));  // doubled
  append(stream, Bytes(5));           // shifted
  model::PacketHeader header = moments_header(6);
  header.lost = 2;
  append(stream, moments_packet(header, spec::kStatusShortLine));
  append(stream, moments_stream(0, 2));  // restarted
  stream.insert(stream.end(), cut.begin(), cut.begin() + 70);
  write_text(folder / "stream", text_of(stream));
  const auto device = driver::open_device("file:" + (folder / "stream").string());
  EXPECT_EQ(read_all(*device), (std::vector<std::uint64_t>{0, 1, 3, 6, 0, 1}));
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 6,
                                                  .flagged = 1,
                                                  .lost_board = 2,
                                                  .missing = 3,
                                                  .bad = 3,
                                                  .resynchronized = 2,
                                                  .bytes_discarded = 145,
                                                  .repeated = 1,
                                                  .restarts = 1}));
}

TEST(FileDevice, Pipe) {
  const ScratchFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const driver::Wait wait : {driver::Wait::polling, driver::Wait::blocking, driver::Wait::polling_then_blocking}) {
    const auto device = driver::open_device("file:" + pipe, {.wait = wait});
    model::PacketView packet;
    EXPECT_EQ(device->next(packet, milliseconds(1)), driver::Next::timeout) << "no writer yet";
    std::thread writer([&] {
      const Bytes stream = moments_stream(0, 1000);
      const int descriptor = open(pipe.c_str(), O_WRONLY);
      Random random(1);
      for (std::size_t at = 0; at < stream.size();) {
        const auto piece = std::min<std::size_t>(static_cast<std::size_t>(random.between(1, 5000)), stream.size() - at);
        ASSERT_EQ(write(descriptor, stream.data() + at, piece), static_cast<ssize_t>(piece));
        at += piece;
      }
      close(descriptor);
    });
    EXPECT_EQ(read_all(*device).size(), 1000U);
    EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 1000}));
    writer.join();
  }
}

// With a time-out of nothing, next() looks once.
TEST(FileDevice, PipeWithoutWaiting) {
  const ScratchFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const auto device = driver::open_device("file:" + pipe);
  const int descriptor = open(pipe.c_str(), O_WRONLY);
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, nanoseconds(0)), driver::Next::timeout);
  for (std::uint64_t first = 0; first < 100; first += 2) {
    const Bytes stream = moments_stream(first, 2);
    ASSERT_EQ(write(descriptor, stream.data(), stream.size()), static_cast<ssize_t>(stream.size()));
    for (std::uint64_t i = first; i < first + 2; ++i) {
      ASSERT_EQ(device->next(packet, nanoseconds(0)), driver::Next::packet);
      EXPECT_EQ(packet.header.sequence, i);
      device->release();
    }
    EXPECT_EQ(device->next(packet, nanoseconds(0)), driver::Next::timeout);
  }
  close(descriptor);
  EXPECT_EQ(device->next(packet, nanoseconds(0)), driver::Next::end);
}

// The last writer goes in the middle of a packet: that is a bad one, and the end, also when another writer comes.
TEST(FileDevice, APipeThatEndsInAPacket) {
  const ScratchFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const auto device = driver::open_device("file:" + pipe);
  const Bytes stream = moments_stream(0, 2);
  const int descriptor = open(pipe.c_str(), O_WRONLY);
  const std::int64_t before = driver::now_ns();
  ASSERT_GT(write(descriptor, stream.data(), stream.size() / 2 + 70), 0);
  close(descriptor);
  EXPECT_EQ(read_all(*device), std::vector<std::uint64_t>{0});
  EXPECT_GE(device->arrival_ns(), before);
  EXPECT_LE(device->arrival_ns(), driver::now_ns());
  const driver::Counters counters{.delivered = 1, .bad = 1, .bytes_discarded = 70};
  EXPECT_EQ(device->counters(), counters);
  const int later = open(pipe.c_str(), O_WRONLY);
  ASSERT_GT(write(later, stream.data(), stream.size()), 0);
  model::PacketView packet;
  EXPECT_EQ(device->next(packet, milliseconds(1)), driver::Next::end);
  close(later);
  EXPECT_EQ(device->counters(), counters);
}

// A time-out that is over, or was never there, makes it look once.
TEST(FileDevice, LessThanNoTime) {
  const ScratchFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const driver::Wait wait : {driver::Wait::polling, driver::Wait::blocking}) {
    const auto device = driver::open_device("file:" + pipe, {.wait = wait});
    const int descriptor = open(pipe.c_str(), O_WRONLY);
    model::PacketView packet;
    EXPECT_EQ(device->next(packet, nanoseconds(-1)), driver::Next::timeout);
    const Bytes bytes = moments_packet(0);
    ASSERT_EQ(write(descriptor, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    EXPECT_EQ(device->next(packet, nanoseconds(-1)), driver::Next::packet);
    close(descriptor);
  }
}

// However far the next packet is: a recorded stream has it now.
TEST(FileDevice, ARecordedStreamIsReadWithoutTime) {
  const ScratchFolder folder;
  Bytes stream(10 * model::kLargestPacketBytes, 1);
  append(stream, moments_packet(7));
  write_text(folder / "a:b+c", text_of(stream));
  const auto device = driver::open_device("file:" + (folder / "a:b+c").string(), {.buffer_bytes = 1});
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, nanoseconds(0)), driver::Next::packet);
  EXPECT_EQ(packet.header.sequence, 7U);
  EXPECT_EQ(device->next(packet, nanoseconds(0)), driver::Next::end);
  EXPECT_EQ(device->next(packet, nanoseconds(0)), driver::Next::end) << "and so it stays";
}

// Address 0 of the process itself cannot be read.
TEST(FileDevice, AFileThatCannotBeReadAnyFurther) {
  const auto device = driver::open_device("file:/proc/self/mem");
  model::PacketView packet;
  EXPECT_EQ(error_of([&] { device->next(packet, nanoseconds(0)); }), "/proc/self/mem: " + files::error_text(EIO));
}

// The number of the descriptor with which this process has a pseudo terminal open.
int terminal_of_this_process() {
  for (int number = 3; number < 1000; ++number) {
    int which = 0;
    if (ioctl(number, TIOCGPTN, &which) == 0) {
      return number;
    }
  }
  return -1;
}

// A terminal whose other side is closed gives an error for every read, until it is opened again.
TEST(FileDevice, ErrorsOfACharacterDeviceAreCounted) {
  const auto device = driver::open_device("file:/dev/ptmx", {.wait = driver::Wait::blocking});
  const int terminal = terminal_of_this_process();
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(unlockpt(terminal), 0);
  const auto other_side = [&] {
    const int side = open(ptsname(terminal), O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios raw{};
    tcgetattr(side, &raw);
    cfmakeraw(&raw);
    tcsetattr(side, TCSANOW, &raw);
    return side;
  };
  const Bytes first = moments_stream(0, 2);
  int side = other_side();
  ASSERT_EQ(write(side, first.data(), first.size() - 100), static_cast<ssize_t>(first.size() - 100));
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, std::chrono::seconds(10)), driver::Next::packet);
  EXPECT_EQ(device->next(packet, milliseconds(1)), driver::Next::timeout);
  EXPECT_EQ(device->counters().read_errors, 0U);
  close(side);
  EXPECT_EQ(device->next(packet, milliseconds(3)), driver::Next::timeout);
  EXPECT_GT(device->counters().read_errors, 0U);
  side = other_side();
  const Bytes second = moments_packet(2);
  ASSERT_EQ(write(side, second.data(), second.size()), static_cast<ssize_t>(second.size()));
  ASSERT_EQ(device->next(packet, std::chrono::seconds(10)), driver::Next::packet);
  EXPECT_EQ(packet.header.sequence, 2U);
  close(side);
  driver::Counters counters = device->counters();
  counters.read_errors = 0;
  EXPECT_EQ(
      counters,
      (driver::Counters{.delivered = 2, .missing = 1, .resynchronized = 1, .bytes_discarded = first.size() / 2 - 100}));
}

TEST(FileDevice, TenThousandStartsInTheMiddle) {
  // A pipe whose reader comes and goes: the bytes in it then begin anywhere.
  const Bytes stream = moments_stream(0, 40);
  const ScratchFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const auto device = driver::open_device("file:" + pipe, {.wait = driver::Wait::polling, .buffer_bytes = 1});
    const int descriptor = open(pipe.c_str(), O_WRONLY);
    const auto begin = static_cast<std::size_t>(random.between(0, static_cast<int>(stream.size() / 2)));
    ASSERT_GT(write(descriptor, stream.data() + begin, stream.size() - begin), 0);
    close(descriptor);
    const std::vector<std::uint64_t> given = read_all(*device);
    const std::size_t size = stream.size() / 40;
    ASSERT_EQ(given.size(), 40 - (begin + size - 1) / size) << "start " << i << " at byte " << begin;
    ASSERT_EQ(given.back(), 39U);
    ASSERT_EQ(device->counters().bad, 0U);
  }
}

TEST(FileDevice, Errors) {
  const ScratchFolder folder;
  EXPECT_THROW(driver::open_device("file:" + (folder / "none").string()), UserError);
  EXPECT_THROW(driver::open_device("file:" + folder.path().string()), UserError);
  for (const char* uri : {"", "file", "file:", "ring:", "usb:0", "ring:a/b", "/dev/null"}) {
    EXPECT_THROW(driver::open_device(uri), UserError) << uri;
  }
  EXPECT_EQ(error_of([] { driver::open_device("ring:"); }), "ring:: the name of the ring is missing");
  EXPECT_EQ(error_of([] { driver::open_device("file:"); }), "file:: the path of the file is missing");
  EXPECT_EQ(error_of([] { driver::open_device("sim:"); }), "sim:: exists only inside selfproj-sim");
  const auto empty = driver::open_device("file:/dev/null");
  EXPECT_TRUE(read_all(*empty).empty());
  const auto zeros = driver::open_device("file:/dev/zero", {.buffer_bytes = 1});
  model::PacketView packet;
  EXPECT_EQ(zeros->next(packet, milliseconds(20)), driver::Next::timeout);
}

constexpr std::size_t kBeat = spec::kPacketBeatBytes;

// Pushes the packet beat by beat; returns the number of beats that were taken.
std::size_t push(driver::SimDevice& device, const Bytes& packet) {
  std::size_t taken = 0;
  for (std::size_t at = 0; at < packet.size(); at += kBeat) {
    taken += device.push(std::span(packet).subspan(at, kBeat), at + kBeat == packet.size()) ? 1 : 0;
  }
  return taken;
}

TEST(SimDevice, BeatsBecomePackets) {
  driver::SimDevice device;
  model::PacketView packet;
  for (std::uint64_t i = 0; i < 10000; ++i) {
    push(device, moments_packet(i, 32));
    ASSERT_EQ(device.next(packet, nanoseconds(0)), driver::Next::packet);
    ASSERT_EQ(packet.header.sequence, i);
    ASSERT_TRUE(is_intact(packet));
    device.release();
    ASSERT_EQ(device.next(packet, nanoseconds(0)), driver::Next::timeout);
  }
  device.finish();
  EXPECT_EQ(device.next(packet, nanoseconds(0)), driver::Next::end);
  EXPECT_EQ(device.misframed(), 0U);
  EXPECT_EQ(device.counters(), (driver::Counters{.delivered = 10000}));
}

TEST(SimDevice, FullBufferStallsTheBus) {
  driver::SimDevice device(1);  // room for two of the largest packets
  const Bytes first = largest_packet(0);
  EXPECT_EQ(push(device, first), first.size() / kBeat);
  EXPECT_EQ(push(device, largest_packet(1)), first.size() / kBeat);
  const Bytes beat(kBeat);
  EXPECT_FALSE(device.push(beat, false));
  model::PacketView packet;
  ASSERT_EQ(device.next(packet, nanoseconds(0)), driver::Next::packet);
  EXPECT_FALSE(device.push(beat, false)) << "the packet that is held would move";
  EXPECT_TRUE(is_intact(packet));
  device.release();
  EXPECT_TRUE(device.push(beat, false));
}

// To ask for the next packet frees the place of the last one, as release() does.
TEST(SimDevice, TheNextCallReleases) {
  driver::SimDevice device(1);
  push(device, largest_packet(0));
  push(device, largest_packet(1));
  model::PacketView packet;
  ASSERT_EQ(device.next(packet, nanoseconds(0)), driver::Next::packet);
  ASSERT_EQ(device.next(packet, nanoseconds(0)), driver::Next::packet);
  EXPECT_FALSE(device.push(Bytes(kBeat), false));
  ASSERT_EQ(device.next(packet, nanoseconds(0)), driver::Next::timeout);
  EXPECT_TRUE(device.push(Bytes(kBeat), false));
}

TEST(SimDevice, EndOfPacketAtTheWrongBeat) {
  driver::SimDevice device;
  Bytes packet = moments_packet(0);
  const std::span<const std::uint8_t> bytes(packet);
  device.push(bytes.first(bytes.size() - kBeat), true);  // one beat early
  device.push(bytes.last(kBeat), true);
  push(device, moments_packet(1));
  EXPECT_EQ(device.misframed(), 2U);
  model::PacketView view;
  EXPECT_EQ(device.next(view, nanoseconds(0)), driver::Next::packet) << "the bytes themselves are right";
}

// It ends in the middle of a packet, of which the bus gave no end.
TEST(SimDevice, FinishedInAPacket) {
  driver::SimDevice device;
  push(device, moments_packet(0));
  push(device, moments_packet(0));
  const Bytes cut = moments_packet(1);
  const std::int64_t arrival = device.arrival_ns();
  EXPECT_GT(arrival, 0);
  device.push(std::span(cut).first(kBeat), false);
  EXPECT_EQ(device.arrival_ns(), arrival) << "nothing has come whole";
  device.finish();
  EXPECT_EQ(device.misframed(), 1U);
  model::PacketView packet;
  EXPECT_EQ(device.next(packet, nanoseconds(0)), driver::Next::packet);
  EXPECT_EQ(device.next(packet, nanoseconds(0)), driver::Next::end);
  EXPECT_EQ(device.counters(), (driver::Counters{.delivered = 1, .bad = 1, .bytes_discarded = kBeat, .repeated = 1}));
  device.finish();
  EXPECT_EQ(device.misframed(), 1U) << "counted once";
}

TEST(SimDevice, NotByUri) { EXPECT_THROW(driver::open_device("sim:"), UserError); }

}  // namespace
}  // namespace selfproj::test
