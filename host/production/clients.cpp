#include "host/production/clients.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <thread>

#include "host/driver/clock.h"
#include "host/production/endpoint.h"

namespace selfproj::production {
namespace {

constexpr std::size_t kMaxClients = 256;
// What the system keeps of an answer that nobody takes.
constexpr int kSendBytes = 1 << 17;

void set_option(int socket, int level, int name, int value) { setsockopt(socket, level, name, &value, sizeof value); }

}  // namespace

std::size_t max_clients() {
  rlimit limit{};
  return getrlimit(RLIMIT_NOFILE, &limit) == 0 ? std::min<std::size_t>(kMaxClients, limit.rlim_cur / 4) : kMaxClients;
}

int accept_client(int listening, SocketAddress& from) {
  constexpr int kSilenceS = 60;
  constexpr int kBetweenS = 10;
  constexpr int kTries = 3;
  from.size = sizeof from.bytes;
  const int socket =
      accept4(listening, reinterpret_cast<sockaddr*>(&from.bytes), &from.size, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (socket >= 0) {
    set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
    set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, kSilenceS);
    set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, kBetweenS);
    set_option(socket, IPPROTO_TCP, TCP_KEEPCNT, kTries);
    set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
    set_option(socket, SOL_SOCKET, SO_SNDBUF, kSendBytes);
  }
  return socket;
}

Machine machine_of(const SocketAddress& address) {
  Machine result{};
  if (address.bytes.ss_family == AF_INET6) {
    const in6_addr& bytes = reinterpret_cast<const sockaddr_in6&>(address.bytes).sin6_addr;
    // IPv4 in IPv6 differs in the last four bytes.
    std::memcpy(result.data(), &bytes.s6_addr[IN6_IS_ADDR_V4MAPPED(&bytes) ? 8 : 0], result.size());
  } else if (address.bytes.ss_family == AF_INET) {
    std::memcpy(result.data(), &reinterpret_cast<const sockaddr_in&>(address.bytes).sin_addr, sizeof(in_addr));
  }
  return result;
}

void Duty::rest() {
  constexpr std::int64_t kShare = 5;
  constexpr std::int64_t kBurstNs = 2'000'000;  // shorter rests are added up
  constexpr std::int64_t kLongestNs = 100'000'000;
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  const std::int64_t cpu = used.tv_sec * 1'000'000'000LL + used.tv_nsec;
  const std::int64_t now = driver::now_ns();
  paid_ns_ = std::max(paid_ns_, now - (cpu - cpu_ns_)) + kShare * (cpu - cpu_ns_);
  cpu_ns_ = cpu;
  if (paid_ns_ - now > kBurstNs) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(paid_ns_ - now, kLongestNs)));
  }
}

}  // namespace selfproj::production
