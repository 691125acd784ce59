#include "sim/target/tap.h"

#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <sys/ioctl.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>

namespace selfproj {

Tap::Tap(const std::string& name) : file_(open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
  ifreq request{};
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  std::copy_n(name.begin(), std::min<std::size_t>(name.size(), IFNAMSIZ - 1), request.ifr_name);
  if (file_ < 0 || ioctl(file_, TUNSETIFF, &request) != 0) {
    const std::string reason = std::strerror(errno);
    if (file_ >= 0) {
      close(file_);
    }
    throw std::runtime_error(name + ": " + reason);
  }
}

Tap::~Tap() { close(file_); }

std::optional<EthernetFrame> Tap::receive() {
  std::array<std::uint8_t, 9216> bytes{};
  const ssize_t size = read(file_, bytes.data(), bytes.size());
  return size > 0 ? std::optional(EthernetFrame(bytes.begin(), bytes.begin() + size)) : std::nullopt;
}

bool Tap::send(const EthernetFrame& frame) {
  return write(file_, frame.data(), frame.size()) == static_cast<ssize_t>(frame.size());
}

}  // namespace selfproj
