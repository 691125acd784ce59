// A board on the network as Etherbone sees it, and a network that loses, repeats and reorders datagrams.
#ifndef SELFPROJ_TESTS_SUPPORT_ETHERBONE_BOARD_H
#define SELFPROJ_TESTS_SUPPORT_ETHERBONE_BOARD_H

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/driver/etherbone.h"
#include "host/driver/udp_socket.h"
#include "model/register_file.h"
#include "sim/board/etherbone_board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// A board that keeps the writes that reached its registers, in order.
class WrittenBoard {
 public:
  struct Write {
    std::uint32_t address;
    std::uint32_t value;
    bool refused;
    bool operator==(const Write&) const = default;
  };

  explicit WrittenBoard(bool mailbox)
      : board_([this](bool write, std::uint32_t address, std::uint32_t data) { return access(write, address, data); },
               mailbox) {}

  std::optional<EtherboneRecord> answer(const EtherboneRecord& question) { return board_.answer(question); }
  [[nodiscard]] const std::vector<Write>& writes() const { return writes_; }
  [[nodiscard]] const RegisterFile& registers() const { return registers_; }

 private:
  RegisterAnswer access(bool write, std::uint32_t address, std::uint32_t data) {
    if (!write) {
      return registers_.read(address, {});
    }
    const RegisterAnswer answer = registers_.write(address, data);
    writes_.push_back({address, data, answer.error});
    return answer;
  }

  RegisterFile registers_;
  std::vector<Write> writes_;
  EtherboneBoard board_;
};

// A thread that is the board and the network before it, at 127.0.0.2.
class BadNetwork {
 public:
  // `percent` of the datagrams, in each direction, is lost, as many are repeated, and as many wait for later ones.
  BadNetwork(WrittenBoard& board, int percent, std::uint64_t seed)
      : board_(board), percent_(percent), random_(seed), socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in here = udp_address("test", {.host = "127.0.0.2", .port = 0});
    socklen_t size = sizeof here;
    if (bind(socket_, reinterpret_cast<sockaddr*>(&here), size) != 0 ||
        getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &size) != 0) {
      throw std::runtime_error("no socket for the board");
    }
    port_ = ntohs(here.sin_port);
    thread_ = std::thread([this] { run(); });
  }
  BadNetwork(const BadNetwork&) = delete;
  BadNetwork& operator=(const BadNetwork&) = delete;
  ~BadNetwork() {
    stop();
    close(socket_);
  }

  // No datagram goes through any more, and the counts stand.
  void stop() {
    stop_ = true;
    if (thread_.joinable()) {
      thread_.join();
    }
  }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  [[nodiscard]] std::uint64_t repeated() const { return repeated_; }
  [[nodiscard]] std::uint64_t late() const { return late_; }

  [[nodiscard]] std::string place() const { return "127.0.0.2:" + std::to_string(port_); }

 private:
  using Datagram = std::pair<sockaddr_in, std::vector<std::uint8_t>>;

  // What comes out of the network where this datagram goes in.
  std::vector<Datagram> through(std::vector<Datagram>& late, Datagram datagram) {
    std::vector<Datagram> out;
    if (random_.chance(percent_)) {
      ++lost_;
      return out;
    }
    if (random_.chance(percent_)) {
      ++late_;
      late.push_back(datagram);
    } else {
      out.push_back(datagram);
    }
    if (random_.chance(percent_)) {
      ++repeated_;
      late.push_back(std::move(datagram));
    }
    while (!late.empty() && random_.chance(30)) {
      const auto which = static_cast<std::size_t>(random_.between(0, static_cast<int>(late.size()) - 1));
      out.push_back(std::move(late[which]));
      late.erase(late.begin() + static_cast<std::ptrdiff_t>(which));
    }
    return out;
  }

  void run() {
    std::array<std::uint8_t, 2048> bytes{};
    while (!stop_) {
      pollfd watched{socket_, POLLIN, 0};
      if (poll(&watched, 1, 10) <= 0) {
        continue;
      }
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t count = recvfrom(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
      if (count < 0) {
        continue;
      }
      for (const auto& [host, question] : through(late_questions_, {from, {bytes.begin(), bytes.begin() + count}})) {
        const std::optional<EtherboneRecord> record = etherbone_record(question);
        const std::optional<EtherboneRecord> answer = record ? board_.answer(*record) : std::nullopt;
        if (!answer) {
          continue;
        }
        for (const auto& [to, reply] : through(late_answers_, {host, etherbone_bytes(*answer)})) {
          static_cast<void>(
              sendto(socket_, reply.data(), reply.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to));
        }
      }
    }
  }

  WrittenBoard& board_;
  int percent_;
  Random random_;
  int socket_;
  std::uint16_t port_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t repeated_ = 0;
  std::uint64_t late_ = 0;
  std::vector<Datagram> late_questions_;
  std::vector<Datagram> late_answers_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_ETHERBONE_BOARD_H
