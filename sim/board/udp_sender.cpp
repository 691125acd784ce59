#include "sim/board/udp_sender.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <string>

#include "host/driver/udp_socket.h"
#include "host/files/file_descriptor.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"

namespace selfproj::sim {

UdpSender::UdpSender(const std::string& to, const std::string& from, bool jumbo)
    : cutter_(static_cast<std::uint16_t>(std::random_device()()),
              jumbo ? model::kJumboDatagramBytes : model::kDatagramBytes),
      to_(driver::udp_address("--udp " + to, driver::udp_place("--udp " + to, to, model::kDatagramPort))),
      waiting_(model::datagrams_of(model::kLargestPacketBytes, model::datagram_piece(model::kDatagramBytes))) {
  socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0) {
    throw UserError("--udp " + to, files::error_text(errno));
  }
  if (!from.empty()) {
    try {
      const sockaddr_in here =
          driver::udp_address("--from " + from, driver::udp_place("--from " + from, from, ntohs(to_.sin_port)));
      if (bind(socket_, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) {
        throw UserError("--from " + from, files::error_text(errno));
      }
    } catch (const UserError&) {
      close(socket_);
      throw;
    }
  }
}

UdpSender::~UdpSender() { close(socket_); }

void UdpSender::send(std::span<const std::uint8_t> packet) {
  cutter_.packet(packet, [this](std::span<const std::uint8_t> datagram) {
    waiting_[count_++].assign(datagram.begin(), datagram.end());
  });
  flush();
}

void UdpSender::finish() {
  for (int i = 0; i < 3; ++i) {
    cutter_.idle([this](std::span<const std::uint8_t> datagram) {
      waiting_[count_++].assign(datagram.begin(), datagram.end());
    });
    flush();
  }
}

void UdpSender::flush() {
  constexpr std::size_t kMost = 32;
  static_assert(model::datagrams_of(model::kLargestPacketBytes, model::datagram_piece(model::kDatagramBytes)) <= kMost);
  std::array<iovec, kMost> pieces{};
  std::array<mmsghdr, kMost> messages{};
  for (std::size_t i = 0; i < count_; ++i) {
    pieces[i] = {waiting_[i].data(), waiting_[i].size()};
    messages[i].msg_hdr.msg_iov = &pieces[i];
    messages[i].msg_hdr.msg_iovlen = 1;
    messages[i].msg_hdr.msg_name = &to_;
    messages[i].msg_hdr.msg_namelen = sizeof to_;
  }
  for (std::size_t sent = 0; sent < count_;) {
    const int done = sendmmsg(socket_, &messages[sent], static_cast<unsigned>(count_ - sent), 0);
    if (done > 0) {
      sent += static_cast<std::size_t>(done);
    } else if (errno == ENOBUFS) {
      pollfd watched{socket_, POLLOUT, 0};
      static_cast<void>(poll(&watched, 1, 1));
    } else if (errno != EINTR) {
      ++failed_;  // nobody listens, or the network is down: the datagram is lost, as it is on a cable
      ++sent;
    }
  }
  count_ = 0;
}

}  // namespace selfproj::sim
