#include "model/datagram.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace selfproj::model {

void DatagramCutter::packet(std::span<const std::uint8_t> packet, const Sink& sink) {
  for (std::size_t offset = 0; offset < packet.size(); offset += piece_) {
    const std::size_t length = std::min(piece_, packet.size() - offset);
    write_datagram_header({.session = session_,
                           .sequence = sequence_++,
                           .packet = packet_,
                           .offset = static_cast<std::uint16_t>(offset),
                           .length = static_cast<std::uint16_t>(length)},
                          datagram_.data());
    std::memcpy(datagram_.data() + spec::kDatagramHeaderBytes, packet.data() + offset, length);
    sink({datagram_.data(), spec::kDatagramHeaderBytes + length});
  }
  ++packet_;
}

void DatagramCutter::idle(const Sink& sink) {
  write_datagram_header({.session = session_, .sequence = sequence_++, .packet = packet_}, datagram_.data());
  sink({datagram_.data(), spec::kDatagramHeaderBytes});
}

}  // namespace selfproj::model
