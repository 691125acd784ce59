// Boards on the network, by the models, and a network that loses, repeats and reorders datagrams.
#ifndef SELFPROJ_TESTS_SUPPORT_NETWORK_BOARD_H
#define SELFPROJ_TESTS_SUPPORT_NETWORK_BOARD_H

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

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
#include "host/files/file_descriptor.h"
#include "model/register_file.h"
#include "model/replay.h"
#include "sim/board/etherbone_board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

struct Datagram {
  sockaddr_in host{};
  std::vector<std::uint8_t> bytes;
};

// One direction of a network. `percent` of the datagrams are lost, as many are repeated, and as many wait for later
// ones.
class BadWay {
 public:
  BadWay(int percent, std::uint64_t seed) : percent_(percent), random_(seed) {}

  // What comes out of the network where this datagram goes in.
  std::vector<Datagram> through(Datagram datagram) {
    std::vector<Datagram> out;
    if (random_.chance(percent_)) {
      ++lost;
      return out;
    }
    if (random_.chance(percent_)) {
      ++late;
      waiting_.push_back(datagram);
    } else {
      out.push_back(datagram);
    }
    if (random_.chance(percent_)) {
      ++repeated;
      waiting_.push_back(std::move(datagram));
    }
    while (!waiting_.empty() && random_.chance(30)) {
      const auto which = random_.between(0, static_cast<int>(waiting_.size()) - 1);
      out.push_back(std::move(waiting_[static_cast<std::size_t>(which)]));
      waiting_.erase(waiting_.begin() + which);
    }
    return out;
  }

  std::uint64_t lost = 0;
  std::uint64_t repeated = 0;
  std::uint64_t late = 0;

 private:
  int percent_;
  Random random_;
  std::vector<Datagram> waiting_;
};

// A port of a board, at an address of this machine; port 0: any.
class BoardSocket {
 public:
  explicit BoardSocket(const std::string& host, std::uint16_t port = 0)
      : file_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in here = driver::udp_address("test", {.host = host, .port = port});
    if (bind(number(), reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) {
      throw std::runtime_error("no socket for the board");
    }
  }

  [[nodiscard]] int number() const { return file_.number(); }
  [[nodiscard]] std::uint16_t port() const {
    sockaddr_in here{};
    socklen_t size = sizeof here;
    getsockname(number(), reinterpret_cast<sockaddr*>(&here), &size);
    return ntohs(here.sin_port);
  }

  // A datagram that waits, if there is one.
  [[nodiscard]] std::optional<Datagram> receive() const {
    Datagram datagram{.bytes = std::vector<std::uint8_t>(2048)};
    socklen_t size = sizeof datagram.host;
    const ssize_t count = recvfrom(number(), datagram.bytes.data(), datagram.bytes.size(), MSG_DONTWAIT,
                                   reinterpret_cast<sockaddr*>(&datagram.host), &size);
    datagram.bytes.resize(count < 0 ? 0 : static_cast<std::size_t>(count));
    return count < 0 ? std::nullopt : std::optional(std::move(datagram));
  }

  void send(const Datagram& datagram) const {
    static_cast<void>(sendto(number(), datagram.bytes.data(), datagram.bytes.size(), 0,
                             reinterpret_cast<const sockaddr*>(&datagram.host), sizeof datagram.host));
  }

 private:
  files::FileDescriptor file_;
};

// The answer of a board to a datagram of Etherbone, if it gives one.
template <class Board>
std::optional<Datagram> answer_to(Board& board, const Datagram& question) {
  const std::optional<driver::EtherboneRecord> record = driver::etherbone_record(question.bytes);
  const std::optional<driver::EtherboneRecord> answer = record ? board.answer(*record) : std::nullopt;
  return answer ? std::optional(Datagram{question.host, driver::etherbone_bytes(*answer)}) : std::nullopt;
}

// A thread that runs `step` again and again until stop().
class Repeating {
 public:
  template <class Step>
  explicit Repeating(const Step& step)
      : thread_([this, step] {
          while (!stop_) {
            step();
          }
        }) {}
  Repeating(const Repeating&) = delete;
  Repeating& operator=(const Repeating&) = delete;
  ~Repeating() { stop(); }

  void stop() {
    stop_ = true;
    if (thread_.joinable()) {
      thread_.join();
    }
  }

 private:
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

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

  std::optional<driver::EtherboneRecord> answer(const driver::EtherboneRecord& question) {
    return board_.answer(question);
  }
  [[nodiscard]] const std::vector<Write>& writes() const { return writes_; }
  [[nodiscard]] const model::RegisterFile& registers() const { return registers_; }

 private:
  model::RegisterAnswer access(bool write, std::uint32_t address, std::uint32_t data) {
    if (!write) {
      return registers_.read(address, {});
    }
    const model::RegisterAnswer answer = registers_.write(address, data);
    writes_.push_back({address, data, answer.error});
    return answer;
  }

  model::RegisterFile registers_;
  std::vector<Write> writes_;
  sim::EtherboneBoard board_;
};

// A thread that is the board and the network before it, at 127.0.0.2.
class BadNetwork {
 public:
  BadNetwork(WrittenBoard& board, int percent, std::uint64_t seed)
      : board_(board), questions_(percent, seed), answers_(percent, seed + 1), thread_([this] { step(); }) {}

  // No datagram goes through any more, and the counts stand.
  void stop() { thread_.stop(); }
  [[nodiscard]] std::uint64_t lost() const { return questions_.lost + answers_.lost; }
  [[nodiscard]] std::uint64_t repeated() const { return questions_.repeated + answers_.repeated; }
  [[nodiscard]] std::uint64_t late() const { return questions_.late + answers_.late; }

  [[nodiscard]] std::string place() const { return "127.0.0.2:" + std::to_string(socket_.port()); }

 private:
  void step() {
    files::wait_readable(socket_.number(), 10'000'000);
    if (std::optional<Datagram> came = socket_.receive()) {
      for (const Datagram& question : questions_.through(*std::move(came))) {
        if (std::optional<Datagram> answer = answer_to(board_, question)) {
          for (const Datagram& reply : answers_.through(*std::move(answer))) {
            socket_.send(reply);
          }
        }
      }
    }
  }

  WrittenBoard& board_;
  BoardSocket socket_{"127.0.0.2"};
  BadWay questions_;
  BadWay answers_;
  Repeating thread_;
};

struct ReplayPorts {
  std::uint16_t etherbone = 0;  // 0: any
  std::uint16_t replay = 0;
};

// A board that replays frames, with a thread of its own; the network before its port of replay is bad.
class ReplayBoard {
 public:
  ReplayBoard(const model::VideoBuild& video, int percent, std::uint64_t seed, const std::string& host = "127.0.0.3",
              const ReplayPorts& ports = {})
      : host_(host),
        replay_(video.replay),
        board_(
            [this](bool write, std::uint32_t address, std::uint32_t data) {
              return write ? registers_.write(address, data) : registers_.read(address, {});
            },
            true, 0, video, &replay_),
        way_(percent, seed),
        etherbone_(host, ports.etherbone),
        frames_port_(host, ports.replay),
        thread_([this] { step(); }) {}

  void stop() { thread_.stop(); }

  [[nodiscard]] std::string etherbone_place() const { return host_ + ":" + std::to_string(etherbone_.port()); }
  [[nodiscard]] std::uint16_t replay_port() const { return frames_port_.port(); }

  // After stop().
  [[nodiscard]] const std::vector<model::ReplayFrame>& frames() const { return frames_; }
  [[nodiscard]] std::uint32_t source() const { return board_.source(); }
  [[nodiscard]] std::uint64_t lost() const { return way_.lost; }

 private:
  void step() {
    std::array<pollfd, 2> watched{{{frames_port_.number(), POLLIN, 0}, {etherbone_.number(), POLLIN, 0}}};
    const int ready = poll(watched.data(), watched.size(), 10);
    if (replay_.leaving()) {  // as long as nothing came, or at least one question
      replay_.left();
    }
    if (ready > 0 && watched[0].revents != 0) {
      // All datagrams that wait, as they would come before a question sent after them.
      while (std::optional<Datagram> came = frames_port_.receive()) {
        for (const Datagram& datagram : way_.through(*std::move(came))) {
          arrive(datagram.bytes);
        }
      }
    } else if (ready > 0) {
      const std::optional<Datagram> question = etherbone_.receive();
      if (const std::optional<Datagram> answer = question ? answer_to(board_, *question) : std::nullopt) {
        etherbone_.send(*answer);
      }
    }
  }

  void arrive(const std::vector<std::uint8_t>& datagram) {
    const bool runs = registers_.settings().run;
    std::optional<model::ReplayFrame> whole = replay_.datagram(
        {.came = datagram, .bytes = datagram.size(), .may_send = runs && board_.source() == spec::kSourceReplay});
    if (whole) {
      frames_.push_back(*std::move(whole));
    }
  }

  std::string host_;
  model::RegisterFile registers_;
  model::ReplayModel replay_;
  sim::EtherboneBoard board_;
  BadWay way_;
  std::vector<model::ReplayFrame> frames_;
  BoardSocket etherbone_;
  BoardSocket frames_port_;
  Repeating thread_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_NETWORK_BOARD_H
