#include "host/driver/etherbone.h"

#include <sys/socket.h>
#include <sys/types.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/udp_socket.h"
#include "host/files/file_descriptor.h"
#include "model/spec/generated/register_table.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
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

// Reads the first word, then `count` words, and removes them from `rest`.
std::vector<std::uint32_t> read_words(std::span<const std::uint8_t>& rest, std::size_t count, std::uint32_t& first) {
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

constexpr std::size_t kMaxReads = 8;  // reads of one request

class EtherbonePort final : public RegisterPort {
 public:
  EtherbonePort(const std::string& place, const EtherboneOptions& options)
      : uri_("udp:" + place),
        options_(options),
        socket_(open_udp_socket(uri_, udp_place(uri_, place, kEtherbonePort))),
        tag_(std::random_device()()) {
    mailbox_ = word(spec::kLinkId) == spec::kLinkIdReset;
  }

  std::vector<std::uint32_t> read(std::span<const std::uint32_t> addresses) override {
    std::vector<std::uint32_t> words;
    for (std::size_t at = 0; at < addresses.size(); at += kMaxReads) {
      const std::span<const std::uint32_t> some = addresses.subspan(at, std::min(kMaxReads, addresses.size() - at));
      EtherboneRecord question;
      question.reads.assign(some.begin(), some.end());
      const std::vector<std::uint32_t> answer = ask(question, options_.tries);
      words.insert(words.end(), answer.begin(), answer.end());
    }
    return words;
  }

  Written write(std::uint32_t address, std::uint32_t value) override {
    EtherboneRecord question;
    if (!mailbox_) {
      question.write_address = address;
      question.writes = {value};
      question.reads = {address};
      static_cast<void>(ask(question, 1));
      return Written::unknown;
    }
    if (!next_ticket_) {
      question.reads = {spec::kLinkTicket};
      next_ticket_ = ask(question, options_.tries).front() + 1;
    }
    const std::uint32_t ticket = *std::exchange(next_ticket_, std::nullopt);  // unknown again if no answer comes
    question.write_address = spec::kLinkTicket;
    question.writes = {ticket, address, value};
    question.reads = {spec::kLinkTicket, spec::kLinkAddress, spec::kLinkValue, spec::kLinkAnswer};
    const std::vector<std::uint32_t> answer = ask(question, options_.tries);
    if (answer[0] != ticket || answer[1] != address || answer[2] != value) {
      throw UserError(uri_, "another host writes this board's registers, or the board was reset");
    }
    next_ticket_ = ticket + 1;
    return (answer[3] >> spec::kLinkAnswerRefusedLsb & 1U) != 0 ? Written::refused : Written::applied;
  }

  [[nodiscard]] const std::string& uri() const override { return uri_; }

 private:
  // Asks until an answer comes. Every request has its own tag; an answer to any request of this call will do.
  std::vector<std::uint32_t> ask(EtherboneRecord& question, int tries) {
    const std::uint32_t first_tag = tag_;
    auto patience = std::chrono::duration_cast<std::chrono::nanoseconds>(options_.patience);
    for (int i = 0; i < tries; ++i) {
      question.tag = tag_++;
      const std::vector<std::uint8_t> bytes = etherbone_bytes(question);
      // An error of the network is like a lost datagram.
      static_cast<void>(send(socket_.number(), bytes.data(), bytes.size(), 0));
      if (std::optional<std::vector<std::uint32_t>> answer =
              answer_within(patience, first_tag, question.reads.size())) {
        return *std::move(answer);
      }
      patience = std::min(2 * patience, 8 * std::chrono::nanoseconds(options_.patience));
    }
    throw UserError(uri_, question.writes.empty()
                              ? "no board answers"
                              : "no answer to a write; it is not known whether the board has got it");
  }

  std::optional<std::vector<std::uint32_t>> answer_within(std::chrono::nanoseconds patience, std::uint32_t first_tag,
                                                          std::size_t words) {
    const std::int64_t end = now_ns() + patience.count();
    std::array<std::uint8_t, 1500> bytes{};
    for (;;) {
      const ssize_t size = recv(socket_.number(), bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (size > 0) {
        const std::optional<EtherboneRecord> answer = etherbone_record({bytes.data(), static_cast<std::size_t>(size)});
        if (answer && answer->writes.size() == words && answer->write_address - first_tag < tag_ - first_tag) {
          return answer->writes;
        }
        continue;
      }
      const std::int64_t left = end - now_ns();
      if (left <= 0) {
        return std::nullopt;
      }
      static_cast<void>(files::wait_readable(socket_.number(), left));
    }
  }

  std::string uri_;
  EtherboneOptions options_;
  files::FileDescriptor socket_;
  std::uint32_t tag_;
  bool mailbox_ = false;
  std::optional<std::uint32_t> next_ticket_;  // empty: to be asked for
};

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
  record.writes = read_words(rest, writes, record.write_address);
  record.reads = read_words(rest, reads, record.tag);
  return record;
}

std::unique_ptr<RegisterPort> make_etherbone_port(const std::string& place, const EtherboneOptions& options) {
  return std::make_unique<EtherbonePort>(place, options);
}

}  // namespace selfproj::driver
