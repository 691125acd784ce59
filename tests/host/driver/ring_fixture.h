// A ring in shared memory for a test, with helpers that write to it and read from it.
#ifndef SELFPROJ_TESTS_HOST_DRIVER_RING_FIXTURE_H
#define SELFPROJ_TESTS_HOST_DRIVER_RING_FIXTURE_H

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/driver/ring_memory.h"
#include "host/driver/ring_writer.h"
#include "selfproj/driver/device.h"
#include "tests/host/driver/packets.h"

namespace selfproj::test {

inline constexpr std::uint32_t kSlots = 16;

// Gives every test its own ring name, and removes the ring at the end.
class Ring : public ::testing::Test {
 protected:
  void SetUp() override { driver::remove_ring(name_); }
  void TearDown() override { driver::remove_ring(name_); }

  std::unique_ptr<driver::Device> open_ring(driver::DeviceOptions options = {}) const {
    return driver::open_device("ring:" + name_, options);
  }

  // A reader that accepts the board's absence.
  [[nodiscard]] std::unique_ptr<driver::Device> open_patient() const { return open_ring({.wait_for_board = true}); }

  [[nodiscard]] driver::RingInfo info() const {
    for (const driver::RingInfo& ring : driver::list_rings()) {
      if (ring.name == name_) {
        return ring;
      }
    }
    return {};
  }

  std::string name_ = "test-" + std::to_string(getpid());
};

inline void write(driver::RingWriter& writer, std::uint64_t first, int count) {
  for (int i = 0; i < count; ++i) {
    writer.write(moments_packet(first + static_cast<std::uint64_t>(i)));
  }
}

// Reads all packets that are there now.
inline std::vector<std::uint64_t> read(driver::Device& device) {
  std::vector<std::uint64_t> sequences;
  model::PacketView packet;
  while (device.next(packet, std::chrono::nanoseconds(0)) == driver::Next::packet) {
    EXPECT_TRUE(is_intact(packet));
    sequences.push_back(packet.header.sequence);
    device.release();
  }
  return sequences;
}

inline std::vector<std::uint64_t> range(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> all;
  for (std::uint64_t i = first; i <= last; ++i) {
    all.push_back(i);
  }
  return all;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_DRIVER_RING_FIXTURE_H
