#ifndef SELFPROJ_HOST_DRIVER_BAR_PORT_H
#define SELFPROJ_HOST_DRIVER_BAR_PORT_H

#include <memory>
#include <string>

#include "host/driver/register_port.h"

namespace selfproj {

// Registers in a file that is mapped into memory, little endian: /dev/xdma0_user, /dev/uio0, the resource file of a
// PCI device, or an ordinary file. `place` is PATH, or PATH+OFFSET where the registers begin at a byte OFFSET, decimal
// or 0x..., a multiple of 4. A write is posted, so its answer is Written::unknown. Throws UserError if the file cannot
// be opened and mapped for reading and writing, or is an ordinary one that is too short. If it is shortened later, the
// registers read as 0.
std::unique_ptr<RegisterPort> make_bar_port(const std::string& place);

// Registers at an open descriptor, which is mapped and then no longer needed. For memfd_create and tests.
std::unique_ptr<RegisterPort> make_bar_port(int descriptor, const std::string& uri);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_BAR_PORT_H
