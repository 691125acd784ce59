// A character device of the kernel, such as a camera of V4L2 or the DMA of a LitePCIe board, behind a seam, so that
// tests can put a player in its place.
#ifndef SELFPROJ_HOST_DRIVER_DEVICE_PORT_H
#define SELFPROJ_HOST_DRIVER_DEVICE_PORT_H

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace selfproj::driver {

class DevicePort {
 public:
  DevicePort() = default;
  DevicePort(const DevicePort&) = delete;
  DevicePort& operator=(const DevicePort&) = delete;
  virtual ~DevicePort() = default;

  // As ioctl(2): returns 0, or the number of the error (errno). Repeats what a signal interrupted.
  virtual int control(unsigned long request, void* argument) = 0;

  // Memory of the device, as mmap(2); null, with errno, if it cannot be mapped. It is unmapped with the port.
  virtual const std::uint8_t* map(std::size_t bytes, std::int64_t offset) = 0;

  // Waits until there is something to take, no longer than this; a signal ends the wait early. Returns whether there
  // is.
  virtual bool wait(std::chrono::nanoseconds timeout) = 0;
};

// Opens the device file. Throws UserError with the URI, which is what the user has written.
std::unique_ptr<DevicePort> open_device_port(const std::string& path, const std::string& uri);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_DEVICE_PORT_H
