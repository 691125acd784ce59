// A board behind LitePCIe's kernel driver: its packets and its registers.
#ifndef SELFPROJ_HOST_DRIVER_LITEPCIE_H
#define SELFPROJ_HOST_DRIVER_LITEPCIE_H

#include <memory>
#include <string>

#include "host/driver/device_port.h"
#include "host/driver/register_port.h"
#include "selfproj/driver/device.h"

namespace selfproj::driver {

// Packets of a board behind LitePCIe's DMA, at the path of its device file, such as /dev/litepcie0.
//
// The DMA writes into a ring of buffers in this machine's memory and does not wait for the reader. So a packet in the
// ring could change while a caller looks at it. The device therefore copies whole buffers out of the mapped ring, looks
// how far the DMA is by then, and gives out only what it cannot have written over during the copy. What was written
// over counts in read_errors, once each time, and in bytes_discarded; missing counts the frames.
//
// The board fills the rest of a buffer with zeros when it has nothing to send. These bytes are not counted.
//
// A board that is reset or loaded anew is started again, and counts in reattached. The device has no end. next() throws
// UserError with the URI when the board has gone. Throws UserError if the file cannot be opened, is no device of
// LitePCIe's driver, or has a reader already.
std::unique_ptr<Device> make_litepcie_device(const std::string& path, const DeviceOptions& options);

// The same on a port that is open.
std::unique_ptr<Device> make_litepcie_device(std::unique_ptr<DevicePort> port, const std::string& uri,
                                             const DeviceOptions& options);

// The registers of a board behind LitePCIe's kernel driver, at the path of its device file, such as /dev/litepcie0. The
// driver makes each access. A write is posted, so its answer is Written::unknown. Another process may read packets
// meanwhile. Throws UserError with the URI if the file cannot be opened or an access fails.
std::unique_ptr<RegisterPort> make_litepcie_port(const std::string& path);

// The same on a port that is open.
std::unique_ptr<RegisterPort> make_litepcie_port(std::unique_ptr<DevicePort> port, const std::string& uri);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_LITEPCIE_H
