// ring:NAME, a device for open_device.
#ifndef SELFPROJ_HOST_DRIVER_RING_DEVICE_H
#define SELFPROJ_HOST_DRIVER_RING_DEVICE_H

#include <memory>
#include <string>

#include "host/driver/device.h"

namespace selfproj {

// The reader of the ring `name`. It first reads packets that were written earlier and not yet released by any reader,
// unless options.discard_backlog is set. Throws as open_device does.
std::unique_ptr<Device> make_ring_device(const std::string& name, const DeviceOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_RING_DEVICE_H
