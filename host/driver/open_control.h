// Opens the control of a board by URI:
//
//     udp:HOST[:PORT]     a board on the network (etherbone_port.h); PORT is that of Etherbone, 1234 unless given
//     bar:PATH[+OFFSET]   registers in a file mapped into memory: /dev/xdma0_user, /dev/uio0, a PCI resource
//                         (bar_port.h)
//     litepcie:PATH       a board behind LitePCIe's kernel driver: /dev/litepcie0 (litepcie_port.h)
//     file:PATH           the control beside a streaming device: /dev/xdma0_user of /dev/xdma0_c2h_0
//     sim:                inside selfproj-sim only
#ifndef SELFPROJ_HOST_DRIVER_OPEN_CONTROL_H
#define SELFPROJ_HOST_DRIVER_OPEN_CONTROL_H

#include <memory>
#include <string>

#include "host/driver/control.h"

namespace selfproj {

// The URI of the control that belongs to a device (open_device.h); empty if the device has none, as recordings and
// rings have none. For udp:HOST:PORT, which has the port of the packets, it is udp:HOST.
std::string control_uri(const std::string& uri);

// Throws UserError with the URI if it is none of the above, or if no board of this specification answers there.
std::unique_ptr<Control> open_control(const std::string& uri);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_OPEN_CONTROL_H
