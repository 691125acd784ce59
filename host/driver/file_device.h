// The device file:PATH for open_device.
#ifndef SELFPROJ_HOST_DRIVER_FILE_DEVICE_H
#define SELFPROJ_HOST_DRIVER_FILE_DEVICE_H

#include <memory>
#include <string>

#include "host/driver/device.h"

namespace selfproj {

// A recorded stream, a pipe, or a streaming character device. Bytes are read into one buffer, and packets are given in
// place.
//
// Next::end means that a regular file is at its end, or that the last writer of a pipe has gone. Errors of a character
// device, such as a DMA time-out, are counted, and reading goes on. The drivers of some devices, such as XDMA, do not
// support poll(2); next() then waits in read(2), even beyond the timeout, until the board sends something. Throws
// UserError if the file cannot be opened or is a folder.
std::unique_ptr<Device> make_file_device(const std::string& path, const DeviceOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_FILE_DEVICE_H
