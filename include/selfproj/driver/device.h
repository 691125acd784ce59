// The driver: one interface to whatever brings the board's packets.
//
//     const std::unique_ptr<Device> device = open_device("ring:line1");
//     PacketView packet;
//     while (device->next(packet, 100ms) != Next::end) {
//       ... packet.header, packet.payload ...
//       device->release();
//     }
#ifndef SELFPROJ_DRIVER_DEVICE_H
#define SELFPROJ_DRIVER_DEVICE_H

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "selfproj/driver/counters.h"
#include "selfproj/model/packet.h"

namespace selfproj::driver {

// How next() waits. Polling has the shortest delay and occupies a processor. Blocking sleeps in the kernel. Polling
// then blocking first polls for DeviceOptions::spin.
enum class Wait : std::uint8_t { polling, blocking, polling_then_blocking };

struct DeviceOptions {
  Wait wait = Wait::polling_then_blocking;
  std::chrono::nanoseconds spin = std::chrono::microseconds(50);  // longer: less delay, more processor time

  // Whether next() polls after it has waited for so long.
  [[nodiscard]] bool polls(std::int64_t waited_ns) const {
    return wait == Wait::polling || (wait == Wait::polling_then_blocking && waited_ns < spin.count());
  }

  // Ring: the ring need not exist yet, and next() continues to wait after the board has gone. Otherwise the ring must
  // exist, and next() returns Next::end once the board has gone and everything is read.
  bool wait_for_board = false;

  // Ring: skip what was written before the device was opened.
  bool discard_backlog = false;

  // File: size in bytes of the buffer that read() fills; at least two of the largest packets.
  std::size_t buffer_bytes = std::size_t{1} << 20U;
};

enum class Next : std::uint8_t {
  packet,   // a packet was given
  timeout,  // no packet came in time
  end,      // no further packet will come
};

// For one thread at a time. Allocates everything when it is opened, and nothing later.
class Device {
 public:
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  // Returns the next good packet in place, without a copy. It stays valid until release() or the next call of next(),
  // which releases it. Waits up to `timeout`; with 0 it looks once. Bad packets are counted and skipped. Throws only
  // UserError, if a file cannot be read any further.
  virtual Next next(model::PacketView& packet, std::chrono::nanoseconds timeout) = 0;

  // Frees the place of the held packet; does nothing if none is held.
  virtual void release() = 0;

  // When the newest packet given by next() came in, in nanoseconds of std::chrono::steady_clock, which all processes of
  // a machine share. For a ring this is when the board put it there, for a file when it was read.
  [[nodiscard]] virtual std::int64_t arrival_ns() const = 0;

  // The counts since the device was opened.
  [[nodiscard]] virtual Counters counters() const = 0;

  // The URI with which it was opened, such as "ring:line1".
  [[nodiscard]] virtual const std::string& uri() const = 0;
};

// Opens a device by its URI:
//
//     ring:NAME         a ring in shared memory, written by a board's driver or by selfproj-sim board
//     file:PATH         a recorded stream, a pipe, or a streaming character device such as /dev/xdma0_c2h_0
//     udp:HOST[:PORT]   a board on the network, which sends packets in datagrams
//     litepcie:PATH     a board on PCI Express behind LitePCIe's kernel driver: /dev/litepcie0
//     sim:              inside selfproj-sim only: SimDevice (host/driver/sim_device.h)
//
// camera:NAME, a camera without a board, is opened by host/camera/camera_device.h. Throws UserError with the URI if it
// is none of the above or cannot be opened: there is no such ring or file, there are no rights, or the ring has another
// layout or specification or already has a reader.
std::unique_ptr<Device> open_device(const std::string& uri, const DeviceOptions& options = {});

}  // namespace selfproj::driver

#endif  // SELFPROJ_DRIVER_DEVICE_H
