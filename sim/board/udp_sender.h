// Sends packets as a board on the network does: in datagrams.
#ifndef SELFPROJ_SIM_BOARD_UDP_SENDER_H
#define SELFPROJ_SIM_BOARD_UDP_SENDER_H

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/datagram.h"

namespace selfproj::sim {

// A socket that sends packets to one host.
class UdpSender {
 public:
  // Sends to `to`, HOST or HOST:PORT, from the address `from` of this machine and the same port number. Throws
  // UserError.
  UdpSender(const std::string& to, const std::string& from, bool jumbo);
  UdpSender(const UdpSender&) = delete;
  UdpSender& operator=(const UdpSender&) = delete;
  ~UdpSender();

  // Sends the datagrams of a packet at once. Waits where the socket's buffer is full.
  void send(std::span<const std::uint8_t> packet);

  // Says, three times, that everything has been sent.
  void finish();

  [[nodiscard]] std::uint32_t datagrams() const { return cutter_.datagrams(); }
  // Datagrams that the system refused to send, for any reason but a full buffer.
  [[nodiscard]] std::uint64_t failed() const { return failed_; }

 private:
  void flush();

  model::DatagramCutter cutter_;
  sockaddr_in to_{};
  int socket_ = -1;
  std::vector<std::vector<std::uint8_t>> waiting_;  // datagrams of one packet; the first count_ of them
  std::size_t count_ = 0;
  std::uint64_t failed_ = 0;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_UDP_SENDER_H
