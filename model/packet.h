// The packet: what the board sends for a frame or for a line of an image. The layout is that of model/spec; the tables
// are in README.md beside this file.
//
//     header, 64 bytes | payload, a multiple of 16 bytes, possibly 0 | trailer, 16 bytes
//
// Little endian, on every machine. A packet counts only once all of it is there and its trailer is right.
#ifndef SELFPROJ_MODEL_PACKET_H
#define SELFPROJ_MODEL_PACKET_H

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/column_moments.h"
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
};

// A packet that was found right, in the bytes it was found in.
struct PacketView {
  PacketHeader header;
  std::span<const std::uint8_t> payload;  // points into the bytes given to parse_packet
  std::uint32_t status = 0;               // 0 = good, else spec::kStatus...
  std::size_t size = 0;                   // bytes of the whole packet: where the next one begins
};

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

// Bytes of the moments of `columns` >= 0 columns: 4 a column in mode binary, 8 in the grey modes, and zeros up to a
// multiple of 16. Throws std::invalid_argument where columns are negative or the mode is none of the three.
std::size_t moments_payload_bytes(Mode mode, int columns);

// Bytes of one line of a raw image: one a pixel, and zeros up to a multiple of 16. Throws as above.
std::size_t image_line_payload_bytes(int columns);

// Bytes of one line of a code image: 2 a pixel, and zeros up to a multiple of 16. Throws as above.
std::size_t codes_line_payload_bytes(int columns);

// Writes the moments of `columns` columns as payload words, moments_payload_bytes(mode, columns) bytes. In mode binary
// n is not read. A value wider than its field loses its high bits; column_moments never gives one.
void pack_moments(Mode mode, int columns, const MomentsView& moments, std::uint8_t* payload);

// The reverse. In mode binary n becomes m0. Bits of the words that belong to no field are not looked at.
void unpack_moments(Mode mode, int columns, const std::uint8_t* payload, const MomentsView& out);

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

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_PACKET_H
