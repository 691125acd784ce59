// The driver: one interface to whatever brings the board's packets. open_device.h opens one by its URI.
//
//     const std::unique_ptr<Device> device = open_device("ring:line1");
//     PacketView packet;
//     while (device->next(packet, 100ms) != Next::end) {
//       ... packet.header, packet.payload ...
//       device->release();
//     }
#ifndef SELFPROJ_HOST_DRIVER_DEVICE_H
#define SELFPROJ_HOST_DRIVER_DEVICE_H

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "host/driver/counters.h"
#include "model/packet.h"

namespace selfproj {

// How next() waits. Polling has the shortest delay and takes a processor of its own; blocking sleeps in the kernel;
// polling then blocking polls for DeviceOptions::spin first.
enum class Wait : std::uint8_t { polling, blocking, polling_then_blocking };

struct DeviceOptions {
  Wait wait = Wait::polling_then_blocking;
  std::chrono::nanoseconds spin = std::chrono::microseconds(50);  // longer: less delay, more processor time

  // Ring: that there is no ring yet is no error, and next() goes on waiting after the board has gone. Without it there
  // must be a ring, and once the board has gone and all is read, next() gives Next::end.
  bool wait_for_board = false;

  // Ring: what was written before the device was opened is skipped.
  bool discard_backlog = false;

  // File: bytes of the buffer that read() fills, at least two of the largest packets.
  std::size_t buffer_bytes = std::size_t{1} << 20U;
};

enum class Next : std::uint8_t {
  packet,   // here is one
  timeout,  // none came in time
  end,      // none will come any more
};

// Not for use by several threads at once. Everything is allocated when the device is opened, nothing later.
class Device {
 public:
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  // The next good packet, in place: it is not copied, and stays valid until release() or the next call of next(), which
  // releases what is still held. Waits up to `timeout`; 0 looks once. Bad packets are counted and passed over.
  // Throws UserError where a file cannot be read any further, and nothing in the other cases.
  virtual Next next(PacketView& packet, std::chrono::nanoseconds timeout) = 0;

  // Gives the held packet's place back; without one, does nothing.
  virtual void release() = 0;

  // When the newest packet given by next() came in: nanoseconds of std::chrono::steady_clock, which all processes of a
  // machine share. For a ring, when the board put it there; for a file, when it was read.
  [[nodiscard]] virtual std::int64_t arrival_ns() const = 0;

  // Since the device was opened.
  [[nodiscard]] virtual Counters counters() const = 0;

  // As it was opened: "ring:line1".
  [[nodiscard]] virtual const std::string& uri() const = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_DEVICE_H
