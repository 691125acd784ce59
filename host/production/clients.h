// Who is connected to a server, and who must go: what the page and the Modbus server share.
#ifndef SELFPROJ_HOST_PRODUCTION_CLIENTS_H
#define SELFPROJ_HOST_PRODUCTION_CLIENTS_H

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <map>

#include "host/production/endpoint.h"

namespace selfproj::production {

// The machine that a client is on. Of IPv6 it is the network, of whose addresses one machine can have any number.
using Machine = std::array<std::uint8_t, 8>;

struct Client {
  Machine machine{};
  std::int64_t since_ns = 0;  // when it came, or made its last progress
};

// How many clients a server has at most: 256, but no more than a quarter of the files that the process may open.
std::size_t max_clients();

// Accepts a connection, which then does not block, and whose other end is asked for a sign of life after a minute of
// silence. Returns its socket, or a negative number if there is none or no descriptor is left.
int accept_client(int listening, SocketAddress& from);

Machine machine_of(const SocketAddress& address);

// The clients of a server by their sockets. Who must go when another one comes is the idlest of the machine that has
// the most: no machine drives out the clients of another one, and who is being served stays.
template <typename T>
using Clients = std::map<int, T>;

template <typename T>
typename Clients<T>::iterator to_make_room(Clients<T>& clients) {
  std::map<Machine, std::size_t> counts;
  std::size_t most = 0;
  for (const auto& [socket, client] : clients) {
    const std::size_t count = ++counts[client.machine];
    most = count > most ? count : most;
  }
  auto result = clients.end();
  for (auto i = clients.begin(); i != clients.end(); ++i) {
    if (counts[i->second.machine] == most &&
        (result == clients.end() || i->second.since_ns < result->second.since_ns)) {
      result = i;
    }
  }
  return result;
}

// How soon accept_clients() can do more after it has returned false.
inline constexpr int kAcceptAgainMs = 10;

// Accepts who waits. Where there are `most` clients, each newcomer makes one go, but nobody within the first quarter of
// a second: a request needs that time to arrive, and who comes then waits. `add` takes a socket and its machine, `drop`
// an iterator of `clients`. Returns false if somebody may wait still who cannot be accepted now.
template <typename T, typename Add, typename Drop>
bool accept_clients(int listening, std::size_t most, Clients<T>& clients, std::int64_t now, const Add& add,
                    const Drop& drop) {
  constexpr int kAtOnce = 32;
  constexpr std::int64_t kGraceNs = 250'000'000;
  for (int i = 0; i < kAtOnce; ++i) {
    const auto leaving = clients.size() < most ? clients.end() : to_make_room(clients);
    if (leaving != clients.end() && now - leaving->second.since_ns < kGraceNs) {
      return false;
    }
    SocketAddress from;
    const int socket = accept_client(listening, from);
    if (socket < 0) {
      return errno != EMFILE && errno != ENFILE && errno != ENOBUFS && errno != ENOMEM;
    }
    if (leaving != clients.end()) {
      drop(leaving);
    }
    add(socket, from);
  }
  return true;
}

// Rests the calling thread so that it takes no more than a fifth of a core, whatever its clients ask for.
class Duty {
 public:
  // Call it after every piece of work, in the thread that works.
  void rest();

 private:
  std::int64_t cpu_ns_ = 0;
  std::int64_t paid_ns_ = 0;  // the time at which the work so far is a fifth
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_CLIENTS_H
