// Sockets to one board on the network.
#ifndef SELFPROJ_HOST_DRIVER_UDP_SOCKET_H
#define SELFPROJ_HOST_DRIVER_UDP_SOCKET_H

#include <netinet/in.h>

#include <cstdint>
#include <string>

namespace selfproj::driver {

struct UdpPlace {
  std::string host;  // name or IPv4 address
  std::uint16_t port = 0;
};

// HOST or HOST:PORT. `name` is what the user gave, for errors. Throws UserError.
UdpPlace udp_place(const std::string& name, const std::string& text, std::uint16_t port);

// Its address. Throws UserError with `name` if the host is not known.
sockaddr_in udp_address(const std::string& name, const UdpPlace& place);

// An open socket, to be closed by the caller, that takes datagrams only from this address, and sends to it. It has the
// same port number on this side, because boards send there. If another program has that port, the socket has any other,
// which is enough for answers, or with `only_there` UserError is thrown. Throws UserError.
int open_udp_socket(const std::string& name, const UdpPlace& place, bool only_there = false);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_UDP_SOCKET_H
