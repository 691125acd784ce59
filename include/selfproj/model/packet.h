// The packet: what the board sends for a frame or for a line of an image. The layout is that of model/spec;
// docs/packet-reference.md has its tables.
//
//     header, 64 bytes | payload, a multiple of 16 bytes, possibly 0 | trailer, 16 bytes
//
// Little endian on every machine. A packet counts only once it is complete and its trailer is right.
#ifndef SELFPROJ_MODEL_PACKET_H
#define SELFPROJ_MODEL_PACKET_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "selfproj/model/column_runs.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/packet_payload.h"

namespace selfproj::model {

// The fields of the header, without those that are the same in every packet (magic, hash, version). A packet
// of an earlier version (spec::kEarlierVersions) has 0 in the fields that it did not know yet, and pixels of 8 bits.
struct PacketHeader {
  std::uint8_t kind = 0;                       // spec::kKind...
  std::uint8_t stream = 0;                     // number of the camera
  std::uint32_t lost = 0;                      // packets of this kind lost so far on the board; wraps
  std::uint64_t sequence = 0;                  // number of the frame
  std::uint64_t time_stamp = 0;                // pixel clocks since reset, at the frame's first beat
  std::uint32_t encoder = 0;                   // encoder count in two's complement, at the frame's first beat
  std::uint32_t payload_size = 0;              // bytes; 0 for a frame that broke before its header left
  std::uint16_t columns = 0;                   // columns of the frame
  std::uint16_t rows = 0;                      // rows of the frame
  std::uint16_t pattern = 0;                   // index of the projected pattern
  std::uint8_t mode = 0;                       // a value of Mode
  std::uint8_t pixel_bits = spec::kPixelBits;  // bits of a pixel, 8..kMaxPixelBits; images and codes have the upper 8
  bool tall = false;                // words of columns are those of a build for more than spec::kMaxRows rows
  std::uint16_t threshold = 0;      // a pixel is lit if it is greater than this
  std::uint16_t first_line = 0;     // first image line in the payload, counted from 1
  std::uint16_t lines = 0;          // image lines in the payload
  std::uint8_t flags = 0;           // spec::kFlag...
  std::uint8_t select = 0;          // a value of Select
  std::uint16_t first_row = 0;      // first row that counts for the moments, from 1; 0: the first
  std::uint16_t last_row = 0;       // last row that counts, from 1; 0: the last
  std::uint8_t gap = 0;             // dark rows between two lit pixels of one run
  std::uint16_t region_row = 0;     // row of the sensor, from 1, at which the frame begins; 0: not said
  std::uint16_t region_column = 0;  // column of the sensor, from 1, at which the frame begins; 0: not said

  bool operator==(const PacketHeader&) const = default;

  // Whether both belong to the same frame, with no restart of the board in between.
  [[nodiscard]] bool same_frame(const PacketHeader& other) const {
    return sequence == other.sequence && time_stamp == other.time_stamp;
  }
};

// A packet that was found right, in the bytes in which it was found.
struct PacketView {
  PacketHeader header;
  std::span<const std::uint8_t> payload;  // points into the bytes given to parse_packet
  std::uint32_t status = 0;               // 0 = good, else spec::kStatus...
  std::size_t size = 0;                   // bytes of the whole packet; the next one begins there

  // The whole packet, header and trailer included.
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return {payload.data() - spec::kHeaderBytes, size}; }
};

// Bytes of a whole packet with this many bytes of payload.
constexpr std::size_t packet_bytes(std::size_t payload_bytes) {
  return spec::kHeaderBytes + payload_bytes + spec::kTrailerBytes;
}

// The largest packet a board sends: moments of the widest image in a grey mode, and a verdict. Packets of images and
// codes hold one line and are smaller. The format could announce many lines, but readers refuse such a packet, so that
// they notice a damaged length within this many bytes.
inline constexpr std::size_t kLargestPacketBytes =
    packet_bytes(std::max(std::size_t{spec::kColumnLimit} * spec::kGreyWordBits,
                          std::size_t{spec::kColumnLimit} * spec::kCodeWordBits) /
                     8 +
                 spec::kVerdictWordBits / 8);
static_assert(kLargestPacketBytes % spec::kPacketBeatBytes == 0);

// The faults of a packet. The length of the header is checked first, then the rest in the order of this list, and the
// length of the packet before its trailer.
enum class PacketError : std::uint8_t {
  none,
  too_short,  // the bytes end before the packet does; with more bytes it may be complete
  magic,      // the bytes are not the beginning of a packet
  hash,       // the sender was built from another specification, neither this one nor a known earlier version
  version,    // the version is not the one that belongs to the hash
  kind,       // unknown kind
  reserved,   // a byte of the header that had no meaning yet in the packet's version is not 0
  geometry,   // mode, select, gap, columns, rows, lines, bits or threshold are impossible, or not of this kind
  size,       // payload_size is neither 0 nor what kind, mode, columns and lines imply
  sequence,   // the sequence in the trailer is not that of the header
  check,      // the check word does not match
  empty,      // the payload is empty although the status is good
};

// The name for messages, as in the list above; "unknown" for any other value.
const char* to_string(PacketError error);

// The check word of a whole packet of at least one beat, the trailer being its last 16 bytes. The check field itself
// counts as 0, whatever it holds. Throws std::invalid_argument if the size is 0 or not a multiple of 16.
//
// c starts as spec::kCheckInit. For each beat of four 32-bit words w0..w3
//     c = 2c mod P  ^  w0  ^  rotl(w1, 8)  ^  rotl(w2, 16)  ^  rotl(w3, 24)
std::uint32_t check_word(std::span<const std::uint8_t> packet);

// Appends a whole packet to `out`: the header, with the payload's size as payload_size (that of `header` is ignored),
// the payload, and the trailer with `status`. Throws std::invalid_argument if the payload is not a multiple of 16
// bytes, if pixel_bits are not in 8..12, or the threshold has more bits. Does not check the header otherwise, so that
// tests can build wrong packets.
void append_packet(const PacketHeader& header, std::span<const std::uint8_t> payload, std::uint32_t status,
                   std::vector<std::uint8_t>& out);

// Writes into `header` the size of a frame, how its columns are measured, and that the packet has all its lines.
void describe_frame(PacketHeader& header, int rows, int columns, const Measure& measure);

// How the header says that columns are measured. The header must be one that parse_packet finds right.
Measure measure_of(const PacketHeader& header);

// Whether packets of this kind tell of the columns of a frame, exact or compact.
constexpr bool has_columns(std::uint8_t kind) { return kind == spec::kKindMoments || kind == spec::kKindCompact; }

// Whether packets of this kind come one for each frame: columns or the verdict. They come in place of each other, and
// the board counts their losses together.
constexpr bool one_for_a_frame(std::uint8_t kind) { return has_columns(kind) || kind == spec::kKindVerdict; }

// Whether the packet has a verdict (unpack_verdict), which is the end of its payload.
constexpr bool has_verdict(const PacketHeader& header) {
  return header.kind == spec::kKindVerdict || (has_columns(header.kind) && (header.flags & spec::kFlagVerdict) != 0);
}

// Whether columns of the grey modes are words wide_grey or wide_grey_run.
constexpr bool has_wide_words(const PacketHeader& header) {
  return header.tall || header.pixel_bits > spec::kPixelBits;
}

// The kind of the packets that tell of columns: exact words in mode binary, which have 32 bits already, else as asked.
constexpr std::uint8_t kind_of_columns(bool compact, Mode mode) {
  return compact && mode != Mode::binary ? spec::kKindCompact : spec::kKindMoments;
}

// The payload of a packet of a frame, if it is not empty: its columns, if it has them, and its verdict, if it has one.
// The header must be one that parse_packet finds right, but for payload_size.
std::size_t frame_payload_bytes(const PacketHeader& header);

// The same of its columns alone. For these, has_columns(header.kind) must hold.
std::size_t columns_payload_bytes(const PacketHeader& header);
ColumnWord column_word(const PacketHeader& header);
void pack_columns(const PacketHeader& header, const RunsView& runs, std::uint8_t* payload);
void unpack_columns(const PacketHeader& header, const std::uint8_t* payload, const RunsView& out);

// Looks for a packet at the beginning of `bytes`, which may hold more. Never reads beyond them; allocates nothing and
// throws nothing. Writes `out` only if it returns PacketError::none.
PacketError parse_packet(std::span<const std::uint8_t> bytes, PacketView& out);

// Whether `bytes` begin as every packet does, as far as they go.
bool begins_like_packet(std::span<const std::uint8_t> bytes);

// The first place in `bytes`, from `from` on, where a packet may begin. Returns bytes.size() if there is none.
std::size_t find_packet_start(std::span<const std::uint8_t> bytes, std::size_t from);

// Bytes of the whole packet according to its header, which need not be right; nothing if the header is incomplete.
std::optional<std::size_t> announced_packet_bytes(std::span<const std::uint8_t> packet);

// The payload within the bytes of a whole packet, which is not checked. Throws std::invalid_argument if there are fewer
// bytes than header and trailer need.
std::span<const std::uint8_t> payload_of(std::span<const std::uint8_t> packet);

// The fields that change when a recorded packet is sent again.
struct PacketStamp {
  std::uint64_t sequence = 0;
  std::uint64_t time_stamp = 0;
  std::uint32_t encoder = 0;
  std::uint32_t lost = 0;
};

// Writes these fields into a whole packet and corrects its check word. Throws std::invalid_argument if the bytes are
// not a whole number of beats, or fewer than header and trailer need.
void stamp_packet(std::span<std::uint8_t> packet, const PacketStamp& stamp);

// Replaces the header of a packet, including payload_size, hash and version of the specification, and corrects the
// check word. For tests of packets that are wrong elsewhere. Throws as above.
void replace_header(std::span<std::uint8_t> packet, const PacketHeader& header, std::uint32_t spec_hash = spec::kHash,
                    std::uint16_t version = spec::kVersion);

// Corrects the check word of a whole packet. Throws as check_word().
void seal_packet(std::span<std::uint8_t> packet);

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_PACKET_H
