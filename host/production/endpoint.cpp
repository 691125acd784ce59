#include "host/production/endpoint.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "host/files/file_descriptor.h"
#include "host/files/numbers.h"
#include "selfproj/files/user_error.h"

namespace selfproj::production {
namespace {

constexpr int kMaxPending = 256;  // connections that wait to be accepted

}  // namespace

bool SocketAddress::is_loopback() const {
  if (bytes.ss_family == AF_INET) {
    constexpr std::uint32_t kFirst = 127;
    return ntohl(reinterpret_cast<const sockaddr_in&>(bytes).sin_addr.s_addr) >> 24U == kFirst;
  }
  const in6_addr& address = reinterpret_cast<const sockaddr_in6&>(bytes).sin6_addr;
  return bytes.ss_family == AF_INET6 && std::memcmp(&address, &in6addr_loopback, sizeof address) == 0;
}

std::vector<SocketAddress> Endpoint::resolved() const {
  // The system also takes 8080 for 0.0.31.144 and 0 for all addresses, which nobody means.
  const bool digits = address.find_first_not_of("0123456789.") == std::string::npos;
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  if (address.empty() || (digits && std::count(address.begin(), address.end(), '.') != 3) ||
      getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) {
    return {};
  }
  std::vector<SocketAddress> result;
  for (const addrinfo* i = found; i != nullptr; i = i->ai_next) {
    SocketAddress one{.size = i->ai_addrlen};
    std::memcpy(&one.bytes, i->ai_addr, i->ai_addrlen);
    const bool known = std::any_of(result.begin(), result.end(), [&](const SocketAddress& other) {
      return other.size == one.size && std::memcmp(&other.bytes, &one.bytes, one.size) == 0;
    });
    if (!known) {
      result.push_back(one);
    }
  }
  freeaddrinfo(found);
  return result;
}

bool Endpoint::is_loopback() const {
  const std::vector<SocketAddress> all = resolved();
  return std::all_of(all.begin(), all.end(), [](const SocketAddress& one) { return one.is_loopback(); });
}

std::string Endpoint::host() const { return address.find(':') == std::string::npos ? address : "[" + address + "]"; }

std::string Endpoint::host_to_open() const {
  if (address != "0.0.0.0" && address != "::") {
    return host();
  }
  std::string found = "127.0.0.1";
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) {
    return found;
  }
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    const bool usable = one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET &&
                        (one->ifa_flags & IFF_UP) != 0 && (one->ifa_flags & IFF_LOOPBACK) == 0;
    std::array<char, INET_ADDRSTRLEN> text{};
    if (usable && inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr, text.data(),
                            text.size()) != nullptr) {
      found = text.data();
      break;
    }
  }
  freeifaddrs(all);
  return found;
}

Endpoint endpoint_of_text(const std::string& option, const std::string& text) {
  Endpoint result;
  const std::size_t colon = text.rfind(':');
  bool good = true;
  if (colon != std::string::npos) {
    result.address = text.substr(0, colon);
    const bool brackets = result.address.starts_with('[') && result.address.ends_with(']');
    result.address = brackets ? result.address.substr(1, result.address.size() - 2) : result.address;
    good = brackets == (result.address.find(':') != std::string::npos);
  }
  const auto port = files::number_of_text<std::uint16_t>(text.substr(colon == std::string::npos ? 0 : colon + 1));
  result.port = port.value_or(0);
  if (!good || result.port == 0 || result.resolved().empty()) {
    throw UserError(option + " " + text,
                    "is neither a port from 1 to 65535 nor ADDRESS:PORT with an address or a name of this machine, of "
                    "IPv6 in brackets");
  }
  return result;
}

std::list<files::FileDescriptor> listen_at(const std::string& option, const Endpoint& endpoint) {
  std::list<files::FileDescriptor> sockets;
  int error = EADDRNOTAVAIL;
  for (const SocketAddress& one : endpoint.resolved()) {
    files::FileDescriptor& made =
        sockets.emplace_back(socket(one.generic()->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const int yes = 1;  // but not SO_REUSEPORT, with which two programs could have one port
    setsockopt(made.number(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (made.number() >= 0 && bind(made.number(), one.generic(), one.size) == 0 &&
        listen(made.number(), kMaxPending) == 0) {
      continue;
    }
    error = errno;
    sockets.pop_back();
    if (error != EADDRNOTAVAIL && error != EAFNOSUPPORT) {  // IPv6 may be turned off, and the name know it all the same
      throw UserError(option + " " + endpoint.text(), files::error_text(error));
    }
  }
  if (sockets.empty()) {
    throw UserError(option + " " + endpoint.text(), files::error_text(error));
  }
  return sockets;
}

}  // namespace selfproj::production
