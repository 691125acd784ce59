// The kinds of devices that open_device opens.
#ifndef SELFPROJ_HOST_DRIVER_DEVICE_KINDS_H
#define SELFPROJ_HOST_DRIVER_DEVICE_KINDS_H

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "selfproj/driver/device.h"
#include "selfproj/driver/packet_reader.h"

namespace selfproj::driver {

// What the kinds have in common. What next() gave stays where it is until the next call of it, unless a kind says
// otherwise.
class TalliedDevice : public Device {
 public:
  TalliedDevice(std::string uri, const DeviceOptions& options)
      : uri_(std::move(uri)), options_(options), tally_(counters_) {}

  void release() override {}
  [[nodiscard]] std::int64_t arrival_ns() const override { return arrival_ns_; }
  [[nodiscard]] Counters counters() const override { return counters_; }
  [[nodiscard]] const std::string& uri() const override { return uri_; }

 protected:
  std::string uri_;
  DeviceOptions options_;
  Counters counters_;
  PacketTally tally_;
  std::int64_t arrival_ns_ = 0;
};

// A recorded stream, a pipe, or a streaming character device. Bytes are read into one buffer, and packets are given in
// place.
//
// Next::end means that a regular file is at its end, or that the last writer of a pipe has gone. Errors of a character
// device, such as a DMA time-out, are counted, and reading goes on. The drivers of some devices, such as XDMA, do not
// support poll(2); next() then waits in read(2), even beyond the timeout, until the board sends something. Throws
// UserError if the file cannot be opened or is a folder.
std::unique_ptr<Device> make_file_device(const std::string& path, const DeviceOptions& options);

// The reader of the ring `name`. It first reads packets that were written earlier and not yet released by any reader,
// unless options.discard_backlog is set. Throws as open_device does.
std::unique_ptr<Device> make_ring_device(const std::string& name, const DeviceOptions& options);

// Packets in datagrams (model/datagram.h) from one board, at HOST or HOST:PORT, port kDatagramPort unless given, to the
// same port of this machine. Datagrams from elsewhere change nothing. A board that falls silent, is unplugged or starts
// anew is waited for; the device has no end. What is incomplete after 20 ms of silence is lost. Throws UserError with
// the URI if the host is not known or another program has the port.
std::unique_ptr<Device> make_udp_device(const std::string& place, const DeviceOptions& options);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_DEVICE_KINDS_H
