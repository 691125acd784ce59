// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.
#ifndef SELFPROJ_SPEC_GENERATED_DATAGRAM_FORMAT_H
#define SELFPROJ_SPEC_GENERATED_DATAGRAM_FORMAT_H

#include <cstddef>
#include <cstdint>

namespace selfproj::spec {

// Byte offsets in the header of a datagram; docs/packet-reference.md says what the fields mean.
inline constexpr std::uint16_t kDatagramMagic = 0x4C53;  // "SL"
inline constexpr std::size_t kDatagramHeaderBytes = 16;
inline constexpr std::size_t kDatagramMagicAt = 0;  // 16 bits
inline constexpr std::size_t kDatagramSession = 2;  // 16 bits
inline constexpr std::size_t kDatagramSequence = 4;  // 32 bits
inline constexpr std::size_t kDatagramPacket = 8;  // 32 bits
inline constexpr std::size_t kDatagramOffset = 12;  // 16 bits
inline constexpr std::size_t kDatagramLength = 14;  // 16 bits

// The same for the datagrams of replay, and the port at which boards receive them.
inline constexpr std::uint16_t kReplayPort = 1236;
inline constexpr std::uint16_t kReplayMagic = 0x5253;  // "SR"
inline constexpr std::size_t kReplayHeaderBytes = 20;
inline constexpr std::size_t kReplayMagicAt = 0;  // 16 bits
inline constexpr std::size_t kReplaySession = 2;  // 16 bits
inline constexpr std::size_t kReplayFrame = 4;  // 32 bits
inline constexpr std::size_t kReplayOffset = 8;  // 32 bits
inline constexpr std::size_t kReplayLength = 12;  // 16 bits
inline constexpr std::size_t kReplayColumns = 14;  // 16 bits
inline constexpr std::size_t kReplayRows = 16;  // 16 bits
inline constexpr std::size_t kReplayReserved = 18;  // 16 bits

}  // namespace selfproj::spec

#endif  // SELFPROJ_SPEC_GENERATED_DATAGRAM_FORMAT_H
