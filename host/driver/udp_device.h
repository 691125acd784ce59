#ifndef SELFPROJ_HOST_DRIVER_UDP_DEVICE_H
#define SELFPROJ_HOST_DRIVER_UDP_DEVICE_H

#include <memory>
#include <string>

#include "host/driver/device.h"

namespace selfproj {

// Packets in datagrams (model/datagram.h) from one board, at HOST or HOST:PORT, port kDatagramPort unless given, to the
// same port of this machine. Datagrams from elsewhere change nothing. A board that falls silent, is unplugged or starts
// anew is waited for; the device has no end. What is incomplete after 20 ms of silence is lost. Throws UserError with
// the URI if the host is not known or another program has the port.
std::unique_ptr<Device> make_udp_device(const std::string& place, const DeviceOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_UDP_DEVICE_H
