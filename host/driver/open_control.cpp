#include "host/driver/open_control.h"

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "host/driver/bar_port.h"
#include "host/driver/etherbone_port.h"
#include "host/driver/litepcie_port.h"
#include "host/files/user_error.h"

namespace selfproj {
namespace {

// "/dev/xdma0_user" of "/dev/xdma0_c2h_0"; empty for any other path.
std::string registers_beside(const std::string& path) {
  const std::size_t channel = path.find("_c2h_");
  const std::size_t name = path.rfind('/') + 1;  // 0 if there is no slash
  return channel == std::string::npos || path.compare(name, 4, "xdma") != 0 ? "" : path.substr(0, channel) + "_user";
}

}  // namespace

std::string control_uri(const std::string& uri) {
  if (uri.starts_with("bar:") || uri.starts_with("litepcie:")) {
    return uri;
  }
  if (uri.starts_with("udp:")) {
    return uri.substr(0, uri.find(':', 4));  // a device's port is that of its packets
  }
  if (uri.starts_with("file:")) {
    const std::string path = registers_beside(uri.substr(5));
    return path.empty() ? "" : "bar:" + path;
  }
  return "";
}

std::unique_ptr<Control> open_control(const std::string& uri) {
  const std::string control = control_uri(uri);
  if (control.starts_with("bar:") && control.size() > 4) {
    return std::make_unique<Control>(make_bar_port(control.substr(4)));
  }
  if (uri.starts_with("udp:")) {
    return std::make_unique<Control>(make_etherbone_port(uri.substr(4)));
  }
  constexpr std::string_view kLitePcie = "litepcie:";
  if (uri.starts_with(kLitePcie) && uri.size() > kLitePcie.size()) {
    return std::make_unique<Control>(make_litepcie_port(uri.substr(kLitePcie.size())));
  }
  if (uri == "bar:" || uri == kLitePcie) {
    throw UserError(uri, "the path of the file is missing");
  }
  const bool device = uri.starts_with("ring:") || uri.starts_with("file:");
  throw UserError(uri, device ? "has no control of a board beside it; use bar:PATH, litepcie:PATH or udp:HOST"
                              : "is not the control of a board; use bar:PATH, litepcie:PATH or udp:HOST");
}

}  // namespace selfproj
