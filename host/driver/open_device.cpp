#include <memory>
#include <string>

#include "host/driver/device_kinds.h"
#include "host/driver/litepcie.h"
#include "selfproj/driver/device.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {

std::unique_ptr<Device> open_device(const std::string& uri, const DeviceOptions& options) {
  const std::size_t colon = uri.find(':');
  const std::string scheme = uri.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : uri.substr(colon + 1);
  if (colon == std::string::npos ||
      (scheme != "ring" && scheme != "file" && scheme != "udp" && scheme != "litepcie" && scheme != "sim")) {
    throw UserError(uri, "is not a device; use ring:NAME, file:PATH, udp:HOST, litepcie:PATH or camera:NAME");
  }
  if (scheme == "sim") {
    throw UserError(uri, "exists only inside selfproj-sim");
  }
  if (scheme == "udp") {
    return make_udp_device(rest, options);
  }
  if (rest.empty()) {
    throw UserError(uri, scheme == "ring" ? "the name of the ring is missing" : "the path of the file is missing");
  }
  if (scheme == "litepcie") {
    return make_litepcie_device(rest, options);
  }
  return scheme == "ring" ? make_ring_device(rest, options) : make_file_device(rest, options);
}

}  // namespace selfproj::driver
