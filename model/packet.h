// The packet: what the board sends for a frame or for a line of an image. The layout is that of model/spec;
// docs/packet-reference.md has its tables.
//
//     header, 64 bytes | payload, a multiple of 16 bytes, possibly 0 | trailer, 16 bytes
//
// Little endian, on every machine. A packet counts only once all of it is there and its trailer is right.
#ifndef SELFPROJ_MODEL_PACKET_H
#define SELFPROJ_MODEL_PACKET_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "model/packet_payload.h"
#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {

// The header's fields, but for those that are the same in every packet (magic, hash, version, reserved).
struct PacketHeader {
  std::uint8_t kind = 0;           // spec::kKind...
  std::uint8_t stream = 0;         // number of the camera
  std::uint32_t lost = 0;          // packets of this kind lost so far on the board; wraps
  std::uint64_t sequence = 0;      // number of the frame
  std::uint64_t time_stamp = 0;    // pixel clocks since reset, at the frame's first beat
  std::uint32_t encoder = 0;       // encoder count in two's complement, at the frame's first beat
  std::uint32_t payload_size = 0;  // bytes; 0 for a frame that broke before its header left
  std::uint16_t columns = 0;       // of the frame
  std::uint16_t rows = 0;          // of the frame
  std::uint16_t pattern = 0;       // index of the projected pattern
  std::uint8_t mode = 0;           // a value of Mode
  std::uint8_t threshold = 0;      // a pixel is lit where it is greater
  std::uint16_t first_line = 0;    // first image line in the payload, counted from 1
  std::uint16_t lines = 0;         // image lines in the payload
  std::uint8_t flags = 0;          // spec::kFlag...

  bool operator==(const PacketHeader&) const = default;

  // Whether both are of one frame of one life of the board.
  [[nodiscard]] bool same_frame(const PacketHeader& other) const {
    return sequence == other.sequence && time_stamp == other.time_stamp;
  }
};

// A packet that was found right, in the bytes it was found in.
struct PacketView {
  PacketHeader header;
  std::span<const std::uint8_t> payload;  // points into the bytes given to parse_packet
  std::uint32_t status = 0;               // 0 = good, else spec::kStatus...
  std::size_t size = 0;                   // bytes of the whole packet: where the next one begins

  // The whole packet, header and trailer included.
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return {payload.data() - spec::kHeaderBytes, size}; }
};

// Bytes of a whole packet with so many bytes of payload.
constexpr std::size_t packet_bytes(std::size_t payload_bytes) {
  return spec::kHeaderBytes + payload_bytes + spec::kTrailerBytes;
}

// The largest packet a board sends: moments of the widest image in a grey mode; images and codes, of which a packet
// holds one line, are smaller. The format could also say many lines: such a packet is refused by those who wait for
// its end, so that a damaged length is noticed within this many bytes.
inline constexpr std::size_t kLargestPacketBytes =
    packet_bytes(std::max(std::size_t{spec::kMaxColumns} * spec::kGreyWordBits,
                          std::size_t{spec::kMaxColumns} * spec::kCodeWordBits) /
                 8);
static_assert(kLargestPacketBytes % spec::kPacketBeatBytes == 0);

// What is wrong with a packet. The length of the header is looked at first, then the rest in the order of the list, and
// the length of the packet before its trailer.
enum class PacketError : std::uint8_t {
  none,
  too_short,  // the bytes end before the packet does; with more bytes it may be whole
  magic,      // the bytes are not the beginning of a packet
  hash,       // the sender was built from another specification
  version,    // likewise
  kind,       // unknown kind
  reserved,   // a reserved byte of the header is not 0
  geometry,   // mode, columns, rows or lines cannot occur
  size,       // payload_size is neither 0 nor what kind, mode, columns and lines imply
  sequence,   // the sequence in the trailer is not that of the header
  check,      // the check word does not match
  empty,      // the payload is empty although the status is good
};

// A name for messages, as in the list above; "unknown" for any other value.
const char* to_string(PacketError error);

// The check word of a whole packet of at least one beat, the trailer being its last 16 bytes; the check field itself
// counts as 0, whatever stands there. Throws std::invalid_argument where the size is 0 or not a multiple of 16.
//
// With c = spec::kCheckInit at first, for each beat of four 32-bit words w0..w3:
//     c = 2c mod P  ^  w0  ^  rotl(w1, 8)  ^  rotl(w2, 16)  ^  rotl(w3, 24)
std::uint32_t check_word(std::span<const std::uint8_t> packet);

// Appends a whole packet to `out`: the header with the payload's own size as payload_size (that of `header` is not
// read), the payload, the trailer with `status`. Throws std::invalid_argument where the payload is not a multiple of
// 16 bytes; whether the header makes sense is not asked, so that tests can build wrong packets too.
void append_packet(const PacketHeader& header, std::span<const std::uint8_t> payload, std::uint32_t status,
                   std::vector<std::uint8_t>& out);

// Looks for a packet at the beginning of `bytes`, which may hold more than it. Never reads outside them; allocates and
// throws nothing. `out` is written only where the answer is PacketError::none.
PacketError parse_packet(std::span<const std::uint8_t> bytes, PacketView& out);

// Whether `bytes` begin as every packet does, as far as there are any.
bool begins_like_packet(std::span<const std::uint8_t> bytes);

// The first place in `bytes`, from `from` on, where a packet may begin: from there on they begin like one. All of them
// where there is none.
std::size_t find_packet_start(std::span<const std::uint8_t> bytes, std::size_t from);

// Bytes of the whole packet, as its header says, which need not be right; nothing while the header is not complete.
std::optional<std::size_t> announced_packet_bytes(std::span<const std::uint8_t> packet);

// The payload in the bytes of a whole packet, which is not judged. Throws std::invalid_argument where they are fewer
// than header and trailer have.
std::span<const std::uint8_t> payload_of(std::span<const std::uint8_t> packet);

// What a recorded packet says anew when it is sent again.
struct PacketStamp {
  std::uint64_t sequence = 0;
  std::uint64_t time_stamp = 0;
  std::uint32_t encoder = 0;
  std::uint32_t lost = 0;
};

// Writes these fields into a whole packet, and makes its check word right. Throws std::invalid_argument where the bytes
// are no whole number of beats, or fewer than header and trailer have.
void stamp_packet(std::span<std::uint8_t> packet, const PacketStamp& stamp);

// Writes the header, with its payload_size and the hash of a specification, over that of a packet, and makes the check
// word right: for tests of packets that are wrong elsewhere. Throws as above.
void replace_header(std::span<std::uint8_t> packet, const PacketHeader& header, std::uint32_t spec_hash = spec::kHash);

// Makes the check word of a whole packet right. Throws as check_word().
void seal_packet(std::span<std::uint8_t> packet);

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_PACKET_H
