#include "host/driver/etherbone_port.h"

#include <poll.h>
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
#include <string>
#include <utility>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/etherbone.h"
#include "host/driver/udp_socket.h"
#include "host/files/file_descriptor.h"
#include "host/files/user_error.h"
#include "model/spec/generated/register_table.h"

namespace selfproj {
namespace {

constexpr std::size_t kMostReads = 8;  // reads of one request

// What the mailbox says of the last write that it has performed.
struct LastWrite {
  std::uint32_t ticket = 0;
  std::uint32_t address = 0;
  std::uint32_t value = 0;
  bool refused = false;
};

class EtherbonePort final : public RegisterPort {
 public:
  EtherbonePort(const std::string& place, const EtherboneOptions& options)
      : uri_("udp:" + place),
        options_(options),
        socket_(open_udp_socket(uri_, udp_place(uri_, place, kEtherbonePort))),
        tag_(std::random_device()()) {
    mailbox_ = read(std::array<std::uint32_t, 1>{spec::kLinkId}).front() == spec::kLinkIdReset;
  }

  std::vector<std::uint32_t> read(std::span<const std::uint32_t> addresses) override {
    std::vector<std::uint32_t> words;
    for (std::size_t at = 0; at < addresses.size(); at += kMostReads) {
      const std::span<const std::uint32_t> some = addresses.subspan(at, std::min(kMostReads, addresses.size() - at));
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
    return (answer[3] >> spec::kLinkAnswerRefusedLsb & 1U) != 0 ? Written::refused : Written::taken;
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
      const timespec limit{static_cast<std::time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
      pollfd watched{socket_.number(), POLLIN, 0};
      static_cast<void>(ppoll(&watched, 1, &limit, nullptr));
    }
  }

  std::string uri_;
  EtherboneOptions options_;
  FileDescriptor socket_;
  std::uint32_t tag_;
  bool mailbox_ = false;
  std::optional<std::uint32_t> next_ticket_;  // empty: to be asked for
};

}  // namespace

std::unique_ptr<RegisterPort> make_etherbone_port(const std::string& place, const EtherboneOptions& options) {
  return std::make_unique<EtherbonePort>(place, options);
}

}  // namespace selfproj
