// file:PATH, a device for open_device.
#ifndef SELFPROJ_HOST_DRIVER_FILE_DEVICE_H
#define SELFPROJ_HOST_DRIVER_FILE_DEVICE_H

#include <memory>
#include <string>

#include "host/driver/device.h"

namespace selfproj {

// A recorded stream, a pipe, or a streaming character device. Bytes are read into one buffer and packets given out of
// it in place.
//
// Next::end: a regular file is at its end, or the last writer of a pipe has gone. Errors of a character device
// (a DMA that timed out, say) are counted and survived. The drivers of some, such as XDMA, know no poll(2): there
// next() waits in read(2), beyond the timeout, until the board sends something. Throws UserError where the file cannot
// be opened, or is a folder.
std::unique_ptr<Device> make_file_device(const std::string& path, const DeviceOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_FILE_DEVICE_H
