// Etherbone as LiteX speaks it: records of 32-bit words in UDP datagrams, big endian, one record in each datagram.
//
//     8 bytes: 4E 6F, 1 << 4 | flags, 44, 0, 0, 0, 0    flags: 1 probe, 2 answer to a probe
//     4 bytes: cycle flags, byte enable, words to write, words to read
//     to write:  4 bytes first address, then 4 bytes for each word
//     to read:   4 bytes tag, then 4 bytes for each address
//
// The answer to a record that reads is a record that writes. Its first address is the tag, and its words are the values
// that were read. A board does the writes in order, then the reads. It answers from its Etherbone port to the same port
// of the host.
#ifndef SELFPROJ_HOST_DRIVER_ETHERBONE_H
#define SELFPROJ_HOST_DRIVER_ETHERBONE_H

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/driver/register_port.h"

namespace selfproj::driver {

inline constexpr std::uint16_t kEtherbonePort = 1234;

// A record with words to write and addresses to read, or a probe, which has neither.
struct EtherboneRecord {
  bool probe = false;         // asks whether somebody is there
  bool probe_answer = false;  // answers a probe
  std::uint32_t write_address = 0;
  std::vector<std::uint32_t> writes{};
  std::uint32_t tag = 0;
  std::vector<std::uint32_t> reads{};

  bool operator==(const EtherboneRecord&) const = default;
};

// Encodes a record as a datagram. Throws std::invalid_argument if there are more than 255 words to write or to read.
std::vector<std::uint8_t> etherbone_bytes(const EtherboneRecord& record);

// Decodes a datagram. Returns nothing unless it is exactly one record. Never reads beyond the end of the datagram.
std::optional<EtherboneRecord> etherbone_record(std::span<const std::uint8_t> datagram);

struct EtherboneOptions {
  std::chrono::milliseconds patience{50};  // until a question is repeated; doubles up to eight times of it
  int tries = 8;                           // questions before the board counts as gone
};

// The registers of a board on the network, at HOST or HOST:PORT, port kEtherbonePort unless given, by LiteX's
// Etherbone. Datagrams may be lost, repeated and reordered.
//
// A read is repeated until an answer comes. A write goes through the board's mailbox (model/write_mailbox.h) with a
// ticket, one more than that of the last write. The board performs a write only if its ticket is the next one. So a
// datagram that comes twice or late changes nothing, and the host repeats it until it has the answer: every write is
// performed once, or refused by the board, or an error says that no answer came and the write may have been performed
// or not. A board without the mailbox gets each write in one datagram that is never repeated. If no answer to it comes,
// that is an error; but the network itself may deliver it twice or late.
//
// Throws UserError with the URI if no board answers.
std::unique_ptr<RegisterPort> make_etherbone_port(const std::string& place, const EtherboneOptions& options = {});

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_ETHERBONE_H
