// Packets for the tests of the driver.
#ifndef SELFPROJ_TESTS_HOST_DRIVER_PACKETS_H
#define SELFPROJ_TESTS_HOST_DRIVER_PACKETS_H

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "selfproj/model/packet.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

using Bytes = std::vector<std::uint8_t>;

// The header of frame `sequence` of a board that ran without a loss at 15,120 clocks a frame.
inline model::PacketHeader moments_header(std::uint64_t sequence, int columns = 16) {
  model::PacketHeader header;
  header.kind = spec::kKindMoments;
  header.sequence = sequence;
  header.time_stamp = 1000 + 15120 * sequence;
  header.columns = static_cast<std::uint16_t>(columns);
  header.rows = 96;
  header.mode = spec::kModeGreyOver;
  return header;
}

// Its packet, with a payload that is unique to this sequence.
inline Bytes moments_packet(const model::PacketHeader& header, std::uint32_t status = 0) {
  Bytes packet;
  model::append_packet(header, Random(header.sequence + 1).bytes(model::frame_payload_bytes(header)), status, packet);
  return packet;
}
inline Bytes moments_packet(std::uint64_t sequence, int columns = 16) {
  return moments_packet(moments_header(sequence, columns));
}

// The largest packet that there is.
inline Bytes largest_packet(std::uint64_t sequence) {
  model::PacketHeader header = moments_header(sequence, spec::kColumnLimit);
  header.flags = spec::kFlagVerdict;
  return moments_packet(header);
}

// The packets of frames first..first + count - 1, one after another.
inline Bytes moments_stream(std::uint64_t first, int count, int columns = 16) {
  Bytes stream;
  for (int i = 0; i < count; ++i) {
    const Bytes packet = moments_packet(first + static_cast<std::uint64_t>(i), columns);
    stream.insert(stream.end(), packet.begin(), packet.end());
  }
  return stream;
}

// Whether the packet equals, to the last byte, what moments_packet makes of its header.
inline bool is_intact(const model::PacketView& packet) {
  const Bytes right = Random(packet.header.sequence + 1).bytes(packet.payload.size());
  return packet.payload.size() == packet.header.payload_size &&
         std::equal(right.begin(), right.end(), packet.payload.begin());
}

inline void append(Bytes& stream, const Bytes& more) { stream.insert(stream.end(), more.begin(), more.end()); }

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_DRIVER_PACKETS_H
