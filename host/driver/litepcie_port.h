#ifndef SELFPROJ_HOST_DRIVER_LITEPCIE_PORT_H
#define SELFPROJ_HOST_DRIVER_LITEPCIE_PORT_H

#include <memory>
#include <string>

#include "host/driver/device_port.h"
#include "host/driver/register_port.h"

namespace selfproj {

// The registers of a board behind LitePCIe's kernel driver, at the path of its device file, such as /dev/litepcie0. The
// driver makes each access. A write is posted, so its answer is Written::unknown. Another process may read packets
// meanwhile. Throws UserError with the URI if the file cannot be opened or an access fails.
std::unique_ptr<RegisterPort> make_litepcie_port(const std::string& path);

// The same on a port that is open.
std::unique_ptr<RegisterPort> make_litepcie_port(std::unique_ptr<DevicePort> port, const std::string& uri);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_LITEPCIE_PORT_H
