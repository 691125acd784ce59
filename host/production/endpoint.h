// Where a server listens: [ADDRESS:]PORT.
#ifndef SELFPROJ_HOST_PRODUCTION_ENDPOINT_H
#define SELFPROJ_HOST_PRODUCTION_ENDPOINT_H

#include <sys/socket.h>

#include <cstdint>
#include <list>
#include <string>
#include <vector>

#include "host/files/file_descriptor.h"

namespace selfproj::production {

// An address of IPv4 or IPv6 with its port, as the system's calls take it.
struct SocketAddress {
  sockaddr_storage bytes{};
  socklen_t size = 0;

  [[nodiscard]] const sockaddr* generic() const { return reinterpret_cast<const sockaddr*>(&bytes); }
  [[nodiscard]] bool is_loopback() const;
};

struct Endpoint {
  std::string address = "127.0.0.1";  // or an address of IPv6, without brackets, or a name
  std::uint16_t port = 0;

  // The addresses of the name; none if it has none.
  [[nodiscard]] std::vector<SocketAddress> resolved() const;
  // Whether only this machine can connect.
  [[nodiscard]] bool is_loopback() const;
  // The address as it stands in a URL, and with the port.
  [[nodiscard]] std::string host() const;
  // The address that a browser can open: of 0.0.0.0 and [::], which stand for all of this machine, the first one by
  // which others reach it, or 127.0.0.1 if there is none.
  [[nodiscard]] std::string host_to_open() const;
  [[nodiscard]] std::string text() const { return host() + ":" + std::to_string(port); }
};

// Throws UserError about `option` if the text is none.
Endpoint endpoint_of_text(const std::string& option, const std::string& text);

// Sockets that listen there and do not block, one for each address of the name. Throws UserError about `option`.
std::list<files::FileDescriptor> listen_at(const std::string& option, const Endpoint& endpoint);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_ENDPOINT_H
