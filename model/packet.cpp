#include "model/packet.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "model/cpu_clones.h"

namespace selfproj {
namespace {

constexpr std::size_t kBeatBytes = spec::kPacketBeatBytes;

// Reads and writes unsigned integers in little-endian order at any address.
template <typename T>
inline T load(const std::uint8_t* bytes) {
  if constexpr (std::endian::native == std::endian::little) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  } else {
    T value = 0;
    for (std::size_t i = 0; i < sizeof value; ++i) {
      value = static_cast<T>(value | static_cast<T>(bytes[i]) << (8 * i));
    }
    return value;
  }
}

template <typename T>
inline void store(std::uint8_t* bytes, T value) {
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(bytes, &value, sizeof value);
  } else {
    for (std::size_t i = 0; i < sizeof value; ++i) {
      bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
  }
}

constexpr std::uint32_t ones32(int bits) { return (std::uint32_t{1} << bits) - 1; }
constexpr std::uint64_t ones64(int bits) { return (std::uint64_t{1} << bits) - 1; }

constexpr std::size_t whole_beats(std::size_t bytes) { return (bytes + kBeatBytes - 1) / kBeatBytes * kBeatBytes; }

constexpr std::size_t kBinaryBytes = spec::kBinaryWordBits / 8;
constexpr std::size_t kGreyBytes = spec::kGreyWordBits / 8;
constexpr std::size_t kCodeBytes = spec::kCodeWordBits / 8;
constexpr std::size_t kPixelBytes = spec::kPixelBits / 8;

bool known(Mode mode) { return mode == Mode::binary || mode == Mode::grey || mode == Mode::grey_over; }

std::size_t moments_bytes(Mode mode, std::size_t columns) {
  return whole_beats(columns * (mode == Mode::binary ? kBinaryBytes : kGreyBytes));
}

std::size_t checked(int columns) {
  if (columns < 0) {
    throw std::invalid_argument("packet: columns are negative");
  }
  return static_cast<std::size_t>(columns);
}

std::size_t checked(Mode mode, int columns) {
  if (!known(mode)) {
    throw std::invalid_argument("packet: unknown mode");
  }
  return checked(columns);
}

// The check word is a polynomial over GF(2) modulo P: after k beats c is x^k c0 + Σ x^(k-1-i) f_i, where f_i is beat i
// folded to 32 bits. Up to 32 beats the sum fits in 64 bits as it is, and is reduced only then, with tables: one beat
// does not wait for another, and the compiler takes several at once.
constexpr int kBeatsAtOnce = 32;
constexpr std::ptrdiff_t kBeat = 16;
static_assert(kBeat == spec::kPacketBeatBytes);

// kReduction[b][v] = v x^(32 + 8 b) mod P.
constexpr std::array<std::array<std::uint32_t, 256>, 4> kReduction = [] {
  std::array<std::array<std::uint32_t, 256>, 4> table{};
  for (std::uint32_t value = 0; value < 256; ++value) {
    std::uint32_t power = value << 24;  // value x^24, and on from there
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
    folded[i] = load<std::uint32_t>(beat) ^ std::rotl(load<std::uint32_t>(beat + 4), 8) ^
                std::rotl(load<std::uint32_t>(beat + 8), 16) ^ std::rotl(load<std::uint32_t>(beat + 12), 24);
  }
  std::uint64_t sum = 0;
  for (int i = 0; i < count; ++i) {
    sum ^= std::uint64_t{folded[i]} << (count - 1 - i);
  }
  return sum;
}

// The share of the beats from `bytes` to `end` in a check word that is `check` before them.
std::uint32_t check_beats(std::uint32_t check, const std::uint8_t* bytes, const std::uint8_t* end) {
  while (bytes != end) {
    const int count = static_cast<int>(std::min<std::ptrdiff_t>(kBeatsAtOnce, (end - bytes) / kBeat));
    check = reduced(std::uint64_t{check} << count ^ sum_of_beats(bytes, count));
    bytes += count * kBeat;
  }
  return check;
}

// What check_word gives, for a packet whose size is known to be right.
std::uint32_t check_of(const std::uint8_t* packet, std::size_t size) {
  const std::uint8_t* last = packet + size - spec::kTrailerBytes;
  std::array<std::uint8_t, spec::kTrailerBytes> trailer;
  std::copy_n(last, trailer.size(), trailer.data());
  store(trailer.data() + spec::kTrailerCheck, std::uint32_t{0});
  return check_beats(check_beats(spec::kCheckInit, packet, last), trailer.data(), trailer.data() + trailer.size());
}

PacketHeader read_header(const std::uint8_t* bytes) {
  PacketHeader header;
  header.kind = bytes[spec::kHeaderKind];
  header.stream = bytes[spec::kHeaderStream];
  header.lost = load<std::uint32_t>(bytes + spec::kHeaderLost);
  header.sequence = load<std::uint64_t>(bytes + spec::kHeaderSequence);
  header.time_stamp = load<std::uint64_t>(bytes + spec::kHeaderTimeStamp);
  header.encoder = load<std::uint32_t>(bytes + spec::kHeaderEncoder);
  header.payload_size = load<std::uint32_t>(bytes + spec::kHeaderPayloadSize);
  header.columns = load<std::uint16_t>(bytes + spec::kHeaderColumns);
  header.rows = load<std::uint16_t>(bytes + spec::kHeaderRows);
  header.pattern = load<std::uint16_t>(bytes + spec::kHeaderPattern);
  header.mode = bytes[spec::kHeaderMode];
  header.threshold = bytes[spec::kHeaderThreshold];
  header.first_line = load<std::uint16_t>(bytes + spec::kHeaderFirstLine);
  header.lines = load<std::uint16_t>(bytes + spec::kHeaderLines);
  header.flags = bytes[spec::kHeaderFlags];
  return header;
}

// Writes all 64 bytes; `bytes` are 0 at first, so that the reserved ones are too.
void write_header(const PacketHeader& header, std::uint32_t payload_size, std::uint8_t* bytes) {
  store(bytes + spec::kHeaderMagic, spec::kMagic);
  store(bytes + spec::kHeaderSpecHash, spec::kHash);
  store(bytes + spec::kHeaderVersion, spec::kVersion);
  store(bytes + spec::kHeaderKind, header.kind);
  store(bytes + spec::kHeaderStream, header.stream);
  store(bytes + spec::kHeaderLost, header.lost);
  store(bytes + spec::kHeaderSequence, header.sequence);
  store(bytes + spec::kHeaderTimeStamp, header.time_stamp);
  store(bytes + spec::kHeaderEncoder, header.encoder);
  store(bytes + spec::kHeaderPayloadSize, payload_size);
  store(bytes + spec::kHeaderColumns, header.columns);
  store(bytes + spec::kHeaderRows, header.rows);
  store(bytes + spec::kHeaderPattern, header.pattern);
  store(bytes + spec::kHeaderMode, header.mode);
  store(bytes + spec::kHeaderThreshold, header.threshold);
  store(bytes + spec::kHeaderFirstLine, header.first_line);
  store(bytes + spec::kHeaderLines, header.lines);
  store(bytes + spec::kHeaderFlags, header.flags);
}

// Whether the lines in the payload are lines of the frame.
bool lines_in_frame(const PacketHeader& header) {
  return header.lines >= 1 && header.first_line >= 1 && header.first_line + header.lines - 1 <= header.rows;
}

// Whether mode, columns, rows and lines can occur. The lines count only where the payload has lines.
bool geometry_is_right(const PacketHeader& header) {
  if (!known(static_cast<Mode>(header.mode)) || header.columns < 1 || header.columns > spec::kMaxColumns ||
      header.columns % spec::kPixelsPerBeat != 0 || header.rows < 1 || header.rows > spec::kMaxRows) {
    return false;
  }
  return header.kind == spec::kKindMoments || header.payload_size == 0 || lines_in_frame(header);
}

// The payload that kind, mode, columns and lines imply, in bytes. Kind and geometry are right.
std::size_t implied_payload_bytes(const PacketHeader& header) {
  const std::size_t columns = header.columns;
  switch (header.kind) {
    case spec::kKindMoments:
      return moments_bytes(static_cast<Mode>(header.mode), columns);
    case spec::kKindCodes:
      return header.lines * whole_beats(columns * kCodeBytes);
    default:
      return header.lines * whole_beats(columns * kPixelBytes);
  }
}

// Judges 64 bytes of header; `header` is what they say.
PacketError judge_header(const std::uint8_t* bytes, const PacketHeader& header) {
  if (load<std::uint32_t>(bytes + spec::kHeaderMagic) != spec::kMagic) {
    return PacketError::magic;
  }
  if (load<std::uint32_t>(bytes + spec::kHeaderSpecHash) != spec::kHash) {
    return PacketError::hash;
  }
  if (load<std::uint16_t>(bytes + spec::kHeaderVersion) != spec::kVersion) {
    return PacketError::version;
  }
  if (header.kind != spec::kKindMoments && header.kind != spec::kKindCodes && header.kind != spec::kKindImage) {
    return PacketError::kind;
  }
  if (std::any_of(bytes + spec::kHeaderReserved, bytes + spec::kHeaderBytes, [](std::uint8_t b) { return b != 0; })) {
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

std::size_t moments_payload_bytes(Mode mode, int columns) { return moments_bytes(mode, checked(mode, columns)); }

std::size_t image_line_payload_bytes(int columns) { return whole_beats(checked(columns) * kPixelBytes); }

std::size_t codes_line_payload_bytes(int columns) { return whole_beats(checked(columns) * kCodeBytes); }

void pack_moments(Mode mode, int columns, const MomentsView& moments, std::uint8_t* payload) {
  const std::size_t count = checked(mode, columns);
  const std::uint32_t* m0 = moments.m0;
  const std::uint32_t* m1 = moments.m1;
  const std::uint32_t* n = moments.n;
  std::uint8_t* __restrict words = payload;
  std::size_t used = 0;
  if (mode == Mode::binary) {
    for (std::size_t i = 0; i < count; ++i) {
      store(words + i * kBinaryBytes, (m1[i] & ones32(spec::kBinaryM1Bits)) << spec::kBinaryM1Lsb |
                                          (m0[i] & ones32(spec::kBinaryM0Bits)) << spec::kBinaryM0Lsb);
    }
    used = count * kBinaryBytes;
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      store(words + i * kGreyBytes, (m1[i] & ones64(spec::kGreyM1Bits)) << spec::kGreyM1Lsb |
                                        (m0[i] & ones64(spec::kGreyM0Bits)) << spec::kGreyM0Lsb |
                                        (n[i] & ones64(spec::kGreyNBits)) << spec::kGreyNLsb);
    }
    used = count * kGreyBytes;
  }
  std::fill(payload + used, payload + moments_bytes(mode, count), std::uint8_t{0});
}

void unpack_moments(Mode mode, int columns, const std::uint8_t* payload, const MomentsView& out) {
  const std::size_t count = checked(mode, columns);
  std::uint32_t* __restrict m0 = out.m0;
  std::uint32_t* __restrict m1 = out.m1;
  std::uint32_t* __restrict n = out.n;
  if (mode == Mode::binary) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto word = load<std::uint32_t>(payload + i * kBinaryBytes);
      m1[i] = word >> spec::kBinaryM1Lsb & ones32(spec::kBinaryM1Bits);
      m0[i] = word >> spec::kBinaryM0Lsb & ones32(spec::kBinaryM0Bits);
      n[i] = m0[i];
    }
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      const auto word = load<std::uint64_t>(payload + i * kGreyBytes);
      m1[i] = static_cast<std::uint32_t>(word >> spec::kGreyM1Lsb & ones64(spec::kGreyM1Bits));
      m0[i] = static_cast<std::uint32_t>(word >> spec::kGreyM0Lsb & ones64(spec::kGreyM0Bits));
      n[i] = static_cast<std::uint32_t>(word >> spec::kGreyNLsb & ones64(spec::kGreyNBits));
    }
  }
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
  const std::size_t size = spec::kHeaderBytes + payload.size() + spec::kTrailerBytes;
  out.resize(begin + size);
  std::uint8_t* packet = out.data() + begin;
  write_header(header, static_cast<std::uint32_t>(payload.size()), packet);
  std::copy(payload.begin(), payload.end(), packet + spec::kHeaderBytes);
  std::uint8_t* trailer = packet + spec::kHeaderBytes + payload.size();
  store(trailer + spec::kTrailerSequence, header.sequence);
  store(trailer + spec::kTrailerStatus, status);
  store(trailer + spec::kTrailerCheck, check_of(packet, size));
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
  const std::size_t size = spec::kHeaderBytes + header.payload_size + spec::kTrailerBytes;
  if (bytes.size() < size) {
    return PacketError::too_short;
  }
  const std::uint8_t* trailer = bytes.data() + size - spec::kTrailerBytes;
  if (load<std::uint64_t>(trailer + spec::kTrailerSequence) != header.sequence) {
    return PacketError::sequence;
  }
  if (load<std::uint32_t>(trailer + spec::kTrailerCheck) != check_of(bytes.data(), size)) {
    return PacketError::check;
  }
  const auto status = load<std::uint32_t>(trailer + spec::kTrailerStatus);
  if (header.payload_size == 0 && status == 0) {
    return PacketError::empty;
  }
  out = {header, bytes.subspan(spec::kHeaderBytes, header.payload_size), status, size};
  return PacketError::none;
}

}  // namespace selfproj
