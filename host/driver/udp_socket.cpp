#include "host/driver/udp_socket.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/types.h>

#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>

#include "host/files/file_descriptor.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
namespace {

const sockaddr* generic(const sockaddr_in& address) { return reinterpret_cast<const sockaddr*>(&address); }

int new_socket(const std::string& name) {
  const int number = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (number < 0) {
    throw UserError(name, files::error_text(errno));
  }
  return number;
}

void connect_to(const std::string& name, int number, const sockaddr_in& to) {
  if (connect(number, generic(to), sizeof to) != 0) {
    throw UserError(name, files::error_text(errno));
  }
}

}  // namespace

UdpPlace udp_place(const std::string& name, const std::string& text, std::uint16_t port) {
  UdpPlace place{.host = text.substr(0, text.find(':')), .port = port};
  if (place.host.size() < text.size()) {
    const std::string_view digits = std::string_view(text).substr(place.host.size() + 1);
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), place.port);
    if (error != std::errc() || stop != digits.data() + digits.size() || place.port == 0) {
      throw UserError(name, "'" + std::string(digits) + "' is not a port, 1 to 65535");
    }
  }
  if (place.host.empty()) {
    throw UserError(name, "the name of the host is missing");
  }
  return place;
}

sockaddr_in udp_address(const std::string& name, const UdpPlace& place) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(place.host.c_str(), nullptr, &hints, &found);
  if (error != 0) {
    throw UserError(name, "the host '" + place.host + "' is not known: " + gai_strerror(error));
  }
  sockaddr_in address = *reinterpret_cast<const sockaddr_in*>(found->ai_addr);
  freeaddrinfo(found);
  address.sin_port = htons(place.port);
  return address;
}

int open_udp_socket(const std::string& name, const UdpPlace& place, bool only_there) {
  const sockaddr_in board = udp_address(name, place);
  // The address of this side is the one from which the system reaches the board.
  sockaddr_in here{};
  socklen_t size = sizeof here;
  {
    const files::FileDescriptor probe(new_socket(name));
    connect_to(name, probe.number(), board);
    if (getsockname(probe.number(), reinterpret_cast<sockaddr*>(&here), &size) != 0) {
      throw UserError(name, files::error_text(errno));
    }
  }
  here.sin_port = board.sin_port;
  const int number = new_socket(name);
  try {
    if (bind(number, generic(here), sizeof here) != 0) {
      if (errno != EADDRINUSE) {
        throw UserError(name, files::error_text(errno));
      }
      if (only_there) {
        throw UserError(name, "another program receives at UDP port " + std::to_string(place.port) +
                                  " of this computer, where the board sends its packets");
      }
      here.sin_port = 0;
      if (bind(number, generic(here), sizeof here) != 0) {
        throw UserError(name, files::error_text(errno));
      }
    }
    connect_to(name, number, board);
  } catch (const UserError&) {
    close(number);
    throw;
  }
  return number;
}

}  // namespace selfproj::driver
