#include "selfproj/model/packet.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>

#include "model/cpu_clones.h"
#include "selfproj/model/little_endian.h"

namespace selfproj::model {
namespace {

constexpr std::size_t kBeatBytes = spec::kPacketBeatBytes;

constexpr std::array<std::uint8_t, 4> kMagicBytes{spec::kMagic & 0xFFU, spec::kMagic >> 8U & 0xFFU,
                                                  spec::kMagic >> 16U & 0xFFU, spec::kMagic >> 24U & 0xFFU};
static_assert(spec::kHeaderMagic == 0, "a packet begins with the magic number");

// The check word is a polynomial over GF(2) modulo P. After k beats c is x^k c0 + Σ x^(k-1-i) f_i, where f_i is beat i
// folded to 32 bits. The sum of up to 32 beats fits in 64 bits and is reduced only then, with tables. Beats thus do not
// wait for each other, and the compiler processes several in parallel.
constexpr int kBeatsAtOnce = 32;
constexpr std::ptrdiff_t kBeat = 16;
static_assert(kBeat == spec::kPacketBeatBytes);

// kReduction[b][v] = v x^(32 + 8 b) mod P.
constexpr std::array<std::array<std::uint32_t, 256>, 4> kReduction = [] {
  std::array<std::array<std::uint32_t, 256>, 4> table{};
  for (std::uint32_t value = 0; value < 256; ++value) {
    std::uint32_t power = value << 24;  // value x^24, then on from there
    for (int bit = 8; bit < 40; ++bit) {
      power = (power << 1) ^ ((power >> 31) != 0 ? spec::kCheckPolynomial : 0);
      if (bit % 8 == 7) {
        table[static_cast<std::size_t>((bit - 15) / 8)][value] = power;
      }
    }
  }
  return table;
}();

std::uint32_t reduced(std::uint64_t sum) {
  return static_cast<std::uint32_t>(sum) ^ kReduction[0][sum >> 32 & 0xFF] ^ kReduction[1][sum >> 40 & 0xFF] ^
         kReduction[2][sum >> 48 & 0xFF] ^ kReduction[3][sum >> 56 & 0xFF];
}

// Σ x^(count-1-i) f_i of `count` <= kBeatsAtOnce beats, not reduced.
SELFPROJ_CLONES std::uint64_t sum_of_beats(const std::uint8_t* bytes, int count) {
  std::array<std::uint32_t, kBeatsAtOnce> folded;
  for (int i = 0; i < count; ++i) {
    const std::uint8_t* beat = bytes + i * kBeat;
    folded[i] = load_little_endian<std::uint32_t>(beat) ^ std::rotl(load_little_endian<std::uint32_t>(beat + 4), 8) ^
                std::rotl(load_little_endian<std::uint32_t>(beat + 8), 16) ^
                std::rotl(load_little_endian<std::uint32_t>(beat + 12), 24);
  }
  std::uint64_t sum = 0;
  for (int i = 0; i < count; ++i) {
    sum ^= std::uint64_t{folded[i]} << (count - 1 - i);
  }
  return sum;
}

// Continues the check word `check` with the beats from `bytes` to `end`.
std::uint32_t check_beats(std::uint32_t check, const std::uint8_t* bytes, const std::uint8_t* end) {
  while (bytes != end) {
    const int count = static_cast<int>(std::min<std::ptrdiff_t>(kBeatsAtOnce, (end - bytes) / kBeat));
    check = reduced(std::uint64_t{check} << count ^ sum_of_beats(bytes, count));
    bytes += count * kBeat;
  }
  return check;
}

// The check word of a packet whose size is known to be right.
std::uint32_t check_of(const std::uint8_t* packet, std::size_t size) {
  const std::uint8_t* last = packet + size - spec::kTrailerBytes;
  std::array<std::uint8_t, spec::kTrailerBytes> trailer;
  std::copy_n(last, trailer.size(), trailer.data());
  store_little_endian(trailer.data() + spec::kTrailerCheck, std::uint32_t{0});
  return check_beats(check_beats(spec::kCheckInit, packet, last), trailer.data(), trailer.data() + trailer.size());
}

PacketHeader read_header(const std::uint8_t* bytes) {
  PacketHeader header;
  header.kind = bytes[spec::kHeaderKind];
  header.stream = bytes[spec::kHeaderStream];
  header.lost = load_little_endian<std::uint32_t>(bytes + spec::kHeaderLost);
  header.sequence = load_little_endian<std::uint64_t>(bytes + spec::kHeaderSequence);
  header.time_stamp = load_little_endian<std::uint64_t>(bytes + spec::kHeaderTimeStamp);
  header.encoder = load_little_endian<std::uint32_t>(bytes + spec::kHeaderEncoder);
  header.payload_size = load_little_endian<std::uint32_t>(bytes + spec::kHeaderPayloadSize);
  header.columns = load_little_endian<std::uint16_t>(bytes + spec::kHeaderColumns);
  header.rows = load_little_endian<std::uint16_t>(bytes + spec::kHeaderRows);
  header.pattern = load_little_endian<std::uint16_t>(bytes + spec::kHeaderPattern);
  header.mode = bytes[spec::kHeaderMode];
  const std::uint32_t pixel = bytes[spec::kHeaderPixel];
  header.pixel_bits = static_cast<std::uint8_t>(
      spec::kPixelBits + field_of(pixel, spec::kHeaderPixelMoreBitsLsb, spec::kHeaderPixelMoreBitsBits));
  header.tall = field_of(pixel, spec::kHeaderPixelTallLsb, spec::kHeaderPixelTallBits) != 0;
  header.threshold = static_cast<std::uint16_t>(
      bytes[spec::kHeaderThreshold] |
      field_of(pixel, spec::kHeaderPixelThresholdHighLsb, spec::kHeaderPixelThresholdHighBits) << 8U);
  header.first_line = load_little_endian<std::uint16_t>(bytes + spec::kHeaderFirstLine);
  header.lines = load_little_endian<std::uint16_t>(bytes + spec::kHeaderLines);
  header.flags = bytes[spec::kHeaderFlags];
  header.select = bytes[spec::kHeaderSelect];
  header.first_row = load_little_endian<std::uint16_t>(bytes + spec::kHeaderFirstRow);
  header.last_row = load_little_endian<std::uint16_t>(bytes + spec::kHeaderLastRow);
  header.gap = bytes[spec::kHeaderGap];
  header.region_row = load_little_endian<std::uint16_t>(bytes + spec::kHeaderRegionRow);
  header.region_column = load_little_endian<std::uint16_t>(bytes + spec::kHeaderRegionColumn);
  return header;
}

// Writes all fields.
void write_header(const PacketHeader& header, std::uint32_t payload_size, std::uint32_t spec_hash,
                  std::uint16_t version, std::uint8_t* bytes) {
  if (header.pixel_bits < spec::kPixelBits || header.pixel_bits > kMaxPixelBits ||
      header.threshold >= 1 << header.pixel_bits) {
    throw std::invalid_argument("packet: pixel_bits are not in 8..12, or the threshold has more");
  }
  store_little_endian(bytes + spec::kHeaderMagic, spec::kMagic);
  store_little_endian(bytes + spec::kHeaderSpecHash, spec_hash);
  store_little_endian(bytes + spec::kHeaderVersion, version);
  store_little_endian(bytes + spec::kHeaderKind, header.kind);
  store_little_endian(bytes + spec::kHeaderStream, header.stream);
  store_little_endian(bytes + spec::kHeaderLost, header.lost);
  store_little_endian(bytes + spec::kHeaderSequence, header.sequence);
  store_little_endian(bytes + spec::kHeaderTimeStamp, header.time_stamp);
  store_little_endian(bytes + spec::kHeaderEncoder, header.encoder);
  store_little_endian(bytes + spec::kHeaderPayloadSize, payload_size);
  store_little_endian(bytes + spec::kHeaderColumns, header.columns);
  store_little_endian(bytes + spec::kHeaderRows, header.rows);
  store_little_endian(bytes + spec::kHeaderPattern, header.pattern);
  store_little_endian(bytes + spec::kHeaderMode, header.mode);
  store_little_endian(bytes + spec::kHeaderThreshold, static_cast<std::uint8_t>(header.threshold & 0xFFU));
  store_little_endian(
      bytes + spec::kHeaderPixel,
      static_cast<std::uint8_t>((header.tall ? 1 : 0) << spec::kHeaderPixelTallLsb |
                                (header.pixel_bits - spec::kPixelBits) << spec::kHeaderPixelMoreBitsLsb |
                                header.threshold >> 8U << spec::kHeaderPixelThresholdHighLsb));
  store_little_endian(bytes + spec::kHeaderFirstLine, header.first_line);
  store_little_endian(bytes + spec::kHeaderLines, header.lines);
  store_little_endian(bytes + spec::kHeaderFlags, header.flags);
  store_little_endian(bytes + spec::kHeaderSelect, header.select);
  store_little_endian(bytes + spec::kHeaderFirstRow, header.first_row);
  store_little_endian(bytes + spec::kHeaderLastRow, header.last_row);
  store_little_endian(bytes + spec::kHeaderGap, header.gap);
  store_little_endian(bytes + spec::kHeaderRegionRow, header.region_row);
  store_little_endian(bytes + spec::kHeaderRegionColumn, header.region_column);
}

// Throws unless there is room for header and trailer.
void check_whole(std::span<const std::uint8_t> packet) {
  if (packet.size() < packet_bytes(0)) {
    throw std::invalid_argument("packet: shorter than header and trailer");
  }
}

std::uint8_t* trailer_of(std::span<std::uint8_t> packet) { return packet.data() + packet.size() - spec::kTrailerBytes; }

// Whether the lines in the payload are within the frame.
bool lines_in_frame(const PacketHeader& header) {
  return header.lines >= 1 && header.first_line >= 1 && header.first_line + header.lines - 1 <= header.rows;
}

// Whether mode, select, gap, columns, rows, lines and pixels are possible. Lines matter only if the payload has lines.
bool geometry_is_right(const PacketHeader& header) {
  if (!is_known(static_cast<Mode>(header.mode)) || !is_known(static_cast<Select>(header.select)) ||
      header.gap > kMaxGap || header.first_row > spec::kRowLimit || header.last_row > spec::kRowLimit) {
    return false;
  }
  if (header.columns < 1 || header.columns > spec::kColumnLimit || header.columns % spec::kPixelsPerBeat != 0 ||
      header.rows < 1 || header.rows > (header.tall ? spec::kRowLimit : spec::kMaxRows)) {
    return false;
  }
  if (header.tall && (header.pixel_bits > kMaxTallBits || has_verdict(header))) {
    return false;
  }
  if (header.pixel_bits > kMaxPixelBits || header.threshold >= 1 << header.pixel_bits) {
    return false;
  }
  if (header.kind == spec::kKindCompact && static_cast<Mode>(header.mode) == Mode::binary) {
    return false;
  }
  return has_columns(header.kind) || header.payload_size == 0 || lines_in_frame(header);
}

// The bytes of payload that kind, mode, columns and lines imply. Kind and geometry must be right.
std::size_t implied_payload_bytes(const PacketHeader& header) {
  switch (header.kind) {
    case spec::kKindMoments:
    case spec::kKindCompact:
    case spec::kKindVerdict:
      return frame_payload_bytes(header);
    case spec::kKindCodes:
      return header.lines * codes_line_payload_bytes(header.columns);
    default:
      return header.lines * image_line_payload_bytes(header.columns);
  }
}

// Checks hash and version, which belong together.
PacketError judge_version(const std::uint8_t* bytes) {
  const auto hash = load_little_endian<std::uint32_t>(bytes + spec::kHeaderSpecHash);
  const auto version = load_little_endian<std::uint16_t>(bytes + spec::kHeaderVersion);
  if (hash == spec::kHash) {
    return version == spec::kVersion ? PacketError::none : PacketError::version;
  }
  for (const spec::EarlierVersion& earlier : spec::kEarlierVersions) {
    if (hash == earlier.hash) {
      return version == earlier.version ? PacketError::none : PacketError::version;
    }
  }
  return PacketError::hash;
}

// The bytes of the header that had no meaning in the packet's version, which must be known.
std::span<const std::uint8_t> reserved_bytes(const std::uint8_t* bytes) {
  const auto hash = load_little_endian<std::uint32_t>(bytes + spec::kHeaderSpecHash);
  for (const spec::EarlierVersion& earlier : spec::kEarlierVersions) {
    if (hash == earlier.hash) {
      return {bytes + earlier.reserved_byte, bytes + spec::kHeaderBytes};
    }
  }
  return {};
}

// Checks 64 bytes of header; `header` holds their values.
PacketError judge_header(const std::uint8_t* bytes, const PacketHeader& header) {
  if (load_little_endian<std::uint32_t>(bytes + spec::kHeaderMagic) != spec::kMagic) {
    return PacketError::magic;
  }
  if (const PacketError error = judge_version(bytes); error != PacketError::none) {
    return error;
  }
  if (!has_columns(header.kind) && header.kind != spec::kKindCodes && header.kind != spec::kKindImage &&
      header.kind != spec::kKindVerdict) {
    return PacketError::kind;
  }
  if (std::ranges::any_of(reserved_bytes(bytes), [](std::uint8_t b) { return b != 0; })) {
    return PacketError::reserved;
  }
  if (!geometry_is_right(header)) {
    return PacketError::geometry;
  }
  if (header.payload_size != 0 && header.payload_size != implied_payload_bytes(header)) {
    return PacketError::size;
  }
  return PacketError::none;
}

}  // namespace

const char* to_string(PacketError error) {
  switch (error) {
    case PacketError::none:
      return "none";
    case PacketError::too_short:
      return "too_short";
    case PacketError::magic:
      return "magic";
    case PacketError::hash:
      return "hash";
    case PacketError::version:
      return "version";
    case PacketError::kind:
      return "kind";
    case PacketError::reserved:
      return "reserved";
    case PacketError::geometry:
      return "geometry";
    case PacketError::size:
      return "size";
    case PacketError::sequence:
      return "sequence";
    case PacketError::check:
      return "check";
    case PacketError::empty:
      return "empty";
  }
  return "unknown";
}

std::uint32_t check_word(std::span<const std::uint8_t> packet) {
  if (packet.empty() || packet.size() % kBeatBytes != 0) {
    throw std::invalid_argument("packet: not a whole number of beats");
  }
  return check_of(packet.data(), packet.size());
}

void append_packet(const PacketHeader& header, std::span<const std::uint8_t> payload, std::uint32_t status,
                   std::vector<std::uint8_t>& out) {
  if (payload.size() % kBeatBytes != 0 || payload.size() > UINT32_MAX) {
    throw std::invalid_argument("packet: the payload is not a whole number of beats, or 4 GiB or more");
  }
  const std::size_t begin = out.size();
  const std::size_t size = packet_bytes(payload.size());
  out.resize(begin + size);
  std::uint8_t* packet = out.data() + begin;
  write_header(header, static_cast<std::uint32_t>(payload.size()), spec::kHash, spec::kVersion,
               packet);  // the rest is 0
  std::copy(payload.begin(), payload.end(), packet + spec::kHeaderBytes);
  std::uint8_t* trailer = packet + spec::kHeaderBytes + payload.size();
  store_little_endian(trailer + spec::kTrailerSequence, header.sequence);
  store_little_endian(trailer + spec::kTrailerStatus, status);
  store_little_endian(trailer + spec::kTrailerCheck, check_of(packet, size));
}

void describe_frame(PacketHeader& header, int rows, int columns, const Measure& measure) {
  header.rows = static_cast<std::uint16_t>(rows);
  header.columns = static_cast<std::uint16_t>(columns);
  header.mode = static_cast<std::uint8_t>(measure.mode);
  header.pixel_bits = static_cast<std::uint8_t>(measure.bits);
  header.threshold = static_cast<std::uint16_t>(measure.threshold);
  header.select = static_cast<std::uint8_t>(measure.select);
  header.gap = static_cast<std::uint8_t>(measure.gap);
  header.first_row = static_cast<std::uint16_t>(measure.window.first);
  header.last_row = static_cast<std::uint16_t>(measure.window.last);
  header.first_line = 1;
  header.lines = header.rows;
  header.tall = rows > spec::kMaxRows;
}

Measure measure_of(const PacketHeader& header) {
  return {.mode = static_cast<Mode>(header.mode),
          .threshold = header.threshold,
          .select = static_cast<Select>(header.select),
          .gap = header.gap,
          .window = {header.first_row, header.last_row},
          .bits = header.pixel_bits};
}

std::size_t columns_payload_bytes(const PacketHeader& header) {
  return header.kind == spec::kKindCompact ? compact_payload_bytes(header.columns)
                                           : moments_payload_bytes(static_cast<Mode>(header.mode), header.columns);
}

std::size_t frame_payload_bytes(const PacketHeader& header) {
  return (has_columns(header.kind) ? columns_payload_bytes(header) : 0) +
         (has_verdict(header) ? static_cast<std::size_t>(spec::kVerdictWordBits / 8) : 0);
}

ColumnWord column_word(const PacketHeader& header) {
  const auto select = static_cast<Select>(header.select);
  if (header.kind == spec::kKindCompact) {
    return select == Select::strongest ? ColumnWord::compact_run : ColumnWord::compact;
  }
  return column_word(select, static_cast<Mode>(header.mode), header.pixel_bits > spec::kPixelBits, header.tall);
}

void pack_columns(const PacketHeader& header, const RunsView& runs, std::uint8_t* payload) {
  if (header.kind == spec::kKindCompact) {
    pack_compact(static_cast<Select>(header.select), header.columns, runs, payload, header.pixel_bits, header.tall);
  } else {
    pack_columns(column_word(header), header.columns, runs, payload);
  }
}

void unpack_columns(const PacketHeader& header, const std::uint8_t* payload, const RunsView& out) {
  unpack_columns(column_word(header), header.columns, payload, out);
}

PacketError parse_packet(std::span<const std::uint8_t> bytes, PacketView& out) {
  if (bytes.size() < spec::kHeaderBytes) {
    return PacketError::too_short;
  }
  const PacketHeader header = read_header(bytes.data());
  const PacketError error = judge_header(bytes.data(), header);
  if (error != PacketError::none) {
    return error;
  }
  const std::size_t size = packet_bytes(header.payload_size);
  if (bytes.size() < size) {
    return PacketError::too_short;
  }
  const std::uint8_t* trailer = bytes.data() + size - spec::kTrailerBytes;
  if (load_little_endian<std::uint64_t>(trailer + spec::kTrailerSequence) != header.sequence) {
    return PacketError::sequence;
  }
  if (load_little_endian<std::uint32_t>(trailer + spec::kTrailerCheck) != check_of(bytes.data(), size)) {
    return PacketError::check;
  }
  const auto status = load_little_endian<std::uint32_t>(trailer + spec::kTrailerStatus);
  if (header.payload_size == 0 && status == 0) {
    return PacketError::empty;
  }
  out = {header, bytes.subspan(spec::kHeaderBytes, header.payload_size), status, size};
  return PacketError::none;
}

bool begins_like_packet(std::span<const std::uint8_t> bytes) {
  return std::equal(bytes.begin(),
                    bytes.begin() + static_cast<std::ptrdiff_t>(std::min(bytes.size(), kMagicBytes.size())),
                    kMagicBytes.begin());
}

std::size_t find_packet_start(std::span<const std::uint8_t> bytes, std::size_t from) {
  for (std::size_t at = from; at < bytes.size(); ++at) {
    const void* found = std::memchr(bytes.data() + at, kMagicBytes[0], bytes.size() - at);
    if (found == nullptr) {
      break;
    }
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes.data());
    if (begins_like_packet(bytes.subspan(at))) {
      return at;
    }
  }
  return bytes.size();
}

std::optional<std::size_t> announced_packet_bytes(std::span<const std::uint8_t> packet) {
  if (packet.size() < spec::kHeaderBytes) {
    return std::nullopt;
  }
  return packet_bytes(load_little_endian<std::uint32_t>(packet.data() + spec::kHeaderPayloadSize));
}

std::span<const std::uint8_t> payload_of(std::span<const std::uint8_t> packet) {
  check_whole(packet);
  return packet.subspan(spec::kHeaderBytes, packet.size() - packet_bytes(0));
}

void stamp_packet(std::span<std::uint8_t> packet, const PacketStamp& stamp) {
  check_whole(packet);
  std::uint8_t* header = packet.data();
  store_little_endian(header + spec::kHeaderSequence, stamp.sequence);
  store_little_endian(header + spec::kHeaderTimeStamp, stamp.time_stamp);
  store_little_endian(header + spec::kHeaderEncoder, stamp.encoder);
  store_little_endian(header + spec::kHeaderLost, stamp.lost);
  store_little_endian(trailer_of(packet) + spec::kTrailerSequence, stamp.sequence);
  seal_packet(packet);
}

void replace_header(std::span<std::uint8_t> packet, const PacketHeader& header, std::uint32_t spec_hash,
                    std::uint16_t version) {
  check_whole(packet);
  write_header(header, header.payload_size, spec_hash, version, packet.data());
  seal_packet(packet);
}

void seal_packet(std::span<std::uint8_t> packet) {
  const std::uint32_t check = check_word(packet);
  store_little_endian(trailer_of(packet) + spec::kTrailerCheck, check);
}

}  // namespace selfproj::model
