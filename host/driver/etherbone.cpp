#include "host/driver/etherbone.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

namespace selfproj {
namespace {

constexpr std::size_t kPacketHeader = 8;
constexpr std::size_t kRecordHeader = 4;
constexpr std::size_t kWord = 4;
constexpr std::uint8_t kVersionBits = 1U << 4U;
constexpr std::uint8_t kProbe = 1;
constexpr std::uint8_t kProbeAnswer = 2;
constexpr std::uint8_t kSizes = 0x44;  // addresses and words of 32 bits
constexpr std::uint8_t kEnable = 0x0F;

void append_word(std::vector<std::uint8_t>& bytes, std::uint32_t word) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(word >> static_cast<unsigned>(shift)));
  }
}

std::uint32_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 24U | std::uint32_t{bytes[at + 1]} << 16U | std::uint32_t{bytes[at + 2]} << 8U |
         bytes[at + 3];
}

// Takes the first word, then `count` words.
std::vector<std::uint32_t> take_words(std::span<const std::uint8_t>& rest, std::size_t count, std::uint32_t& first) {
  std::vector<std::uint32_t> words;
  if (count == 0) {
    return words;
  }
  first = word_at(rest, 0);
  words.reserve(count);
  for (std::size_t i = 1; i <= count; ++i) {
    words.push_back(word_at(rest, i * kWord));
  }
  rest = rest.subspan((count + 1) * kWord);
  return words;
}

}  // namespace

std::vector<std::uint8_t> etherbone_bytes(const EtherboneRecord& record) {
  if (record.writes.size() > UINT8_MAX || record.reads.size() > UINT8_MAX) {
    throw std::invalid_argument("an Etherbone record has at most 255 words of each kind");
  }
  const std::uint32_t flags = (record.probe ? kProbe : 0U) | (record.probe_answer ? kProbeAnswer : 0U);
  std::vector<std::uint8_t> bytes;
  bytes.reserve(kPacketHeader + kRecordHeader + kWord * (record.writes.size() + record.reads.size() + 2));
  append_word(bytes, 0x4E6F'0000U | (kVersionBits | flags) << 8U | kSizes);
  append_word(bytes, 0);
  if (record.writes.empty() && record.reads.empty()) {
    return bytes;
  }
  append_word(bytes, std::uint32_t{kEnable} << 16U | static_cast<std::uint32_t>(record.writes.size() << 8U) |
                         static_cast<std::uint32_t>(record.reads.size()));
  const auto append = [&](std::uint32_t first, const std::vector<std::uint32_t>& words) {
    if (!words.empty()) {
      append_word(bytes, first);
      for (const std::uint32_t word : words) {
        append_word(bytes, word);
      }
    }
  };
  append(record.write_address, record.writes);
  append(record.tag, record.reads);
  return bytes;
}

std::optional<EtherboneRecord> etherbone_record(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kPacketHeader || datagram[0] != 0x4E || datagram[1] != 0x6F ||
      (datagram[2] & 0xF0U) != kVersionBits || datagram[3] != kSizes) {
    return std::nullopt;
  }
  EtherboneRecord record;
  record.probe = (datagram[2] & kProbe) != 0;
  record.probe_answer = (datagram[2] & kProbeAnswer) != 0;
  std::span<const std::uint8_t> rest = datagram.subspan(kPacketHeader);
  if (record.probe || record.probe_answer || rest.empty()) {
    return record;  // a sender may fill up a probe
  }
  if (rest.size() < kRecordHeader) {
    return std::nullopt;
  }
  const std::size_t writes = rest[2];
  const std::size_t reads = rest[3];
  rest = rest.subspan(kRecordHeader);
  const auto needed = [](std::size_t words) { return words == 0 ? 0 : (words + 1) * kWord; };
  if (rest.size() != needed(writes) + needed(reads)) {
    return std::nullopt;
  }
  record.writes = take_words(rest, writes, record.write_address);
  record.reads = take_words(rest, reads, record.tag);
  return record;
}

}  // namespace selfproj
