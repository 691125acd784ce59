// Cuts packets into datagrams, as rtl/link does.
#ifndef SELFPROJ_MODEL_DATAGRAM_CUTTER_H
#define SELFPROJ_MODEL_DATAGRAM_CUTTER_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "model/datagram.h"

namespace selfproj {

// One session of a sender.
class DatagramCutter {
 public:
  // Receives a whole datagram.
  using Sink = std::function<void(std::span<const std::uint8_t> datagram)>;

  // `datagram_bytes`: the longest datagram, 32..65535. So many datagrams and packets of the session came before.
  explicit DatagramCutter(std::uint16_t session, std::size_t datagram_bytes = kDatagramBytes,
                          std::uint32_t datagrams = 0, std::uint32_t packets = 0)
      : session_(session),
        piece_(datagram_piece(datagram_bytes)),
        sequence_(datagrams),
        packet_(packets),
        datagram_(datagram_bytes) {}

  // Gives the datagrams of a packet of whole beats, up to 65,535 bytes.
  void packet(std::span<const std::uint8_t> packet, const Sink& sink);

  // Gives the datagram of a sender that has nothing to send.
  void idle(const Sink& sink);

  [[nodiscard]] std::uint32_t datagrams() const { return sequence_; }

 private:
  std::uint16_t session_;
  std::size_t piece_;
  std::uint32_t sequence_;
  std::uint32_t packet_;
  std::vector<std::uint8_t> datagram_;
};

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_DATAGRAM_CUTTER_H
