// How packets are sent in datagrams: the header of a datagram, and the pieces of a packet. docs/packet-reference.md
// defines the format.
#ifndef SELFPROJ_MODEL_DATAGRAM_H
#define SELFPROJ_MODEL_DATAGRAM_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "model/spec/generated/datagram_format.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/little_endian.h"

namespace selfproj::model {

struct DatagramHeader {
  std::uint16_t session = 0;
  std::uint32_t sequence = 0;
  std::uint32_t packet = 0;
  std::uint16_t offset = 0;
  std::uint16_t length = 0;  // 0: the sender is idle

  bool operator==(const DatagramHeader&) const = default;
};

inline constexpr std::uint16_t kDatagramPort = 1235;  // UDP port from which and to which boards send by default

// Bytes of UDP payload in Ethernet's ordinary frames (1,500 bytes) and in jumbo frames (9,000 bytes).
inline constexpr std::size_t kDatagramBytes = 1472;
inline constexpr std::size_t kJumboDatagramBytes = 8972;

// Returns the bytes of the longest piece of a packet in a datagram of this many bytes. A piece consists of whole beats.
constexpr std::size_t datagram_piece(std::size_t datagram_bytes) {
  return (datagram_bytes - spec::kDatagramHeaderBytes) / spec::kPacketBeatBytes * spec::kPacketBeatBytes;
}

// Returns the number of datagrams for a packet of this many bytes in pieces of `piece` bytes.
constexpr std::size_t datagrams_of(std::size_t packet_bytes, std::size_t piece) {
  return (packet_bytes + piece - 1) / piece;
}

// Writes spec::kDatagramHeaderBytes bytes.
inline void write_datagram_header(const DatagramHeader& header, std::uint8_t* bytes) {
  store_little_endian(bytes + spec::kDatagramMagicAt, spec::kDatagramMagic);
  store_little_endian(bytes + spec::kDatagramSession, header.session);
  store_little_endian(bytes + spec::kDatagramSequence, header.sequence);
  store_little_endian(bytes + spec::kDatagramPacket, header.packet);
  store_little_endian(bytes + spec::kDatagramOffset, header.offset);
  store_little_endian(bytes + spec::kDatagramLength, header.length);
}

// Returns the header of a datagram. Returns nothing if this is not a datagram of a board, if it is cut off, or if its
// piece or the offset of the piece is not a whole number of beats. A datagram without a piece may have up to one beat
// of padding behind its header. Some senders need this, because Ethernet frames have a least length.
inline std::optional<DatagramHeader> read_datagram_header(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < spec::kDatagramHeaderBytes) {
    return std::nullopt;
  }
  const std::uint8_t* const bytes = datagram.data();
  const DatagramHeader header{.session = load_little_endian<std::uint16_t>(bytes + spec::kDatagramSession),
                              .sequence = load_little_endian<std::uint32_t>(bytes + spec::kDatagramSequence),
                              .packet = load_little_endian<std::uint32_t>(bytes + spec::kDatagramPacket),
                              .offset = load_little_endian<std::uint16_t>(bytes + spec::kDatagramOffset),
                              .length = load_little_endian<std::uint16_t>(bytes + spec::kDatagramLength)};
  const std::size_t behind = datagram.size() - spec::kDatagramHeaderBytes;
  const bool whole = behind == header.length || (header.length == 0 && behind <= spec::kPacketBeatBytes);
  if (load_little_endian<std::uint16_t>(bytes + spec::kDatagramMagicAt) != spec::kDatagramMagic || !whole ||
      header.offset % spec::kPacketBeatBytes != 0 || header.length % spec::kPacketBeatBytes != 0) {
    return std::nullopt;
  }
  return header;
}

// Cuts packets into datagrams, as rtl/link does: one session of a sender.
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

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_DATAGRAM_H
