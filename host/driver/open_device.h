// Opens devices by URI:
//
//     ring:NAME   a ring in shared memory, written by a board's driver or by selfproj-sim board   (ring_layout.h)
//     file:PATH   a recorded stream, a pipe, or a streaming character device such as /dev/xdma0_c2h_0
//     udp:HOST[:PORT]   a board on the network, which sends packets in datagrams   (udp_device.h)
//     litepcie:PATH     a board on PCI Express behind LitePCIe's kernel driver: /dev/litepcie0   (litepcie_device.h)
//     sim:        inside selfproj-sim only: SimDevice (sim_device.h)
//
// camera:NAME, a camera without a board, is opened by camera/camera_device.h.
#ifndef SELFPROJ_HOST_DRIVER_OPEN_DEVICE_H
#define SELFPROJ_HOST_DRIVER_OPEN_DEVICE_H

#include <memory>
#include <string>

#include "host/driver/device.h"

namespace selfproj {

// Opens the device. Throws UserError with the URI if it is none of the above or cannot be opened: there is no such ring
// or file, there are no rights, or the ring has another layout or specification or already has a reader.
std::unique_ptr<Device> open_device(const std::string& uri, const DeviceOptions& options = {});

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_OPEN_DEVICE_H
