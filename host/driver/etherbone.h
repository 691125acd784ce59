// Etherbone as LiteX speaks it: records of 32-bit words in UDP datagrams, big endian, one record a datagram.
//
//     8 bytes: 4E 6F, 1 << 4 | flags, 44, 0, 0, 0, 0    flags: 1 probe, 2 answer to a probe
//     4 bytes: cycle flags, byte enable, words to write, words to read
//     to write:  4 bytes first address, 4 bytes a word
//     to read:   4 bytes tag, 4 bytes an address
//
// The answer to a record that reads is a record that writes: its first address is the tag, its words are what was read.
// A board does the writes in order, then the reads. It answers from its port to the same port of the host.
#ifndef SELFPROJ_HOST_DRIVER_ETHERBONE_H
#define SELFPROJ_HOST_DRIVER_ETHERBONE_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace selfproj {

inline constexpr std::uint16_t kEtherbonePort = 1234;

// Also a probe, which has no words.
struct EtherboneRecord {
  bool probe = false;         // asks whether somebody is there
  bool probe_answer = false;  // answers a probe
  std::uint32_t write_address = 0;
  std::vector<std::uint32_t> writes{};
  std::uint32_t tag = 0;
  std::vector<std::uint32_t> reads{};

  bool operator==(const EtherboneRecord&) const = default;
};

// The datagram of a record of at most 255 words of each kind. Throws std::invalid_argument if there are more.
std::vector<std::uint8_t> etherbone_bytes(const EtherboneRecord& record);

// The record in a datagram; nothing if it is not exactly one. Never reads beyond it.
std::optional<EtherboneRecord> etherbone_record(std::span<const std::uint8_t> datagram);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_ETHERBONE_H
