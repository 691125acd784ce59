// Packets for the tests of packets.
#ifndef SELFPROJ_TESTS_UNIT_PACKETS_H
#define SELFPROJ_TESTS_UNIT_PACKETS_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/model/packet.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

using Bytes = std::vector<std::uint8_t>;

inline constexpr std::size_t kBeat = spec::kPacketBeatBytes;

// A header with a different value in every field, fit for a payload of the kind.
inline model::PacketHeader header_of(std::uint8_t kind, model::Mode mode, int columns) {
  model::PacketHeader header;
  header.kind = kind;
  header.stream = 0x21;
  header.lost = 0x31323334;
  header.sequence = 0x4142434445464748;
  header.time_stamp = 0x5152535455565758;
  header.encoder = 0xF1F2F3F4;
  header.columns = static_cast<std::uint16_t>(columns);
  header.rows = 96;
  header.pattern = 0x6162;
  header.mode = static_cast<std::uint8_t>(mode);
  header.threshold = 0x71;
  header.first_line = 7;
  header.lines = 1;
  header.flags = spec::kFlagStrayBefore;
  header.select = spec::kSelectStrongest;
  header.first_row = 0x0181;
  header.last_row = 0x0291;
  header.gap = 3;
  header.region_row = 0x1234;
  header.region_column = 0x8765;
  return header;
}

inline std::size_t payload_bytes_of(const model::PacketHeader& header) {
  switch (header.kind) {
    case spec::kKindMoments:
    case spec::kKindCompact:
    case spec::kKindVerdict:
      return model::frame_payload_bytes(header);
    case spec::kKindCodes:
      return header.lines * model::codes_line_payload_bytes(header.columns);
    default:
      return header.lines * model::image_line_payload_bytes(header.columns);
  }
}

// A good packet with a random payload.
inline Bytes packet_of(model::PacketHeader header, std::uint64_t seed = 1) {
  Bytes packet;
  model::append_packet(header, Random(seed).bytes(payload_bytes_of(header)), 0, packet);
  return packet;
}

// One of each kind and format.
inline std::vector<Bytes> packets_of_all_kinds(int columns) {
  std::vector<Bytes> packets;
  packets.push_back(packet_of(header_of(spec::kKindMoments, model::Mode::binary, columns)));
  packets.push_back(packet_of(header_of(spec::kKindMoments, model::Mode::grey, columns)));
  packets.push_back(packet_of(header_of(spec::kKindMoments, model::Mode::grey_over, columns)));
  packets.push_back(packet_of(header_of(spec::kKindCodes, model::Mode::binary, columns)));
  packets.push_back(packet_of(header_of(spec::kKindImage, model::Mode::binary, columns)));
  packets.push_back(packet_of(header_of(spec::kKindCompact, model::Mode::grey, columns)));
  packets.push_back(packet_of(header_of(spec::kKindVerdict, model::Mode::binary, columns)));
  model::PacketHeader both = header_of(spec::kKindMoments, model::Mode::grey, columns);
  both.flags |= spec::kFlagVerdict;
  packets.push_back(packet_of(both));
  return packets;
}

inline model::PacketError verdict(const Bytes& bytes) {
  model::PacketView view;
  return model::parse_packet(bytes, view);
}

// The check word as the prose of the specification defines it, one bit at a time.
inline std::uint32_t plain_check_word(const Bytes& packet) {
  std::uint32_t c = spec::kCheckInit;
  for (std::size_t at = 0; at < packet.size(); at += kBeat) {
    const bool out = (c & 0x80000000U) != 0;
    c <<= 1;
    if (out) {
      c ^= spec::kCheckPolynomial;
    }
    for (std::size_t i = 0; i < kBeat; ++i) {
      if (at + i >= packet.size() - 4) {
        break;  // the check field counts as 0
      }
      for (std::size_t bit = 0; bit < 8; ++bit) {
        if ((packet[at + i] >> bit & 1) != 0) {
          const std::size_t place = 8 * (i % 4) + bit;          // in the word
          c ^= std::uint32_t{1} << ((place + i / 4 * 8) % 32);  // word k is rotated left by 8 k
        }
      }
    }
  }
  return c;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_UNIT_PACKETS_H
