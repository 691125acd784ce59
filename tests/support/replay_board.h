// A board on the network that replays frames, by the models, and a network that loses, doubles and reorders what comes
// to its port of replay.
#ifndef SELFPROJ_TESTS_SUPPORT_REPLAY_BOARD_H
#define SELFPROJ_TESTS_SUPPORT_REPLAY_BOARD_H

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
#include "model/replay.h"
#include "sim/board/etherbone_board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

struct ReplayPorts {
  std::uint16_t etherbone = 0;  // 0: any
  std::uint16_t replay = 0;
};

// A thread of its own, at an address of this machine.
class ReplayBoard {
 public:
  // `percent` of the datagrams of replay are lost, as many doubled, and as many late.
  ReplayBoard(const VideoBuild& video, int percent, std::uint64_t seed, std::string host = "127.0.0.3",
              const ReplayPorts& ports = {})
      : percent_(percent),
        random_(seed),
        host_(std::move(host)),
        replay_(video.replay),
        board_(
            [this](bool write, std::uint32_t address, std::uint32_t data) {
              return write ? registers_.write(address, data) : registers_.read(address, {});
            },
            true, 0, video, &replay_),
        etherbone_(bound(ports.etherbone)),
        frames_port_(bound(ports.replay)),
        thread_([this] { run(); }) {}
  ReplayBoard(const ReplayBoard&) = delete;
  ReplayBoard& operator=(const ReplayBoard&) = delete;
  ~ReplayBoard() {
    stop();
    close(etherbone_);
    close(frames_port_);
  }

  void stop() {
    stop_ = true;
    if (thread_.joinable()) {
      thread_.join();
    }
  }

  [[nodiscard]] std::string etherbone_place() const { return host_ + ":" + std::to_string(port_of(etherbone_)); }
  [[nodiscard]] std::uint16_t replay_port() const { return port_of(frames_port_); }

  // After stop().
  [[nodiscard]] const std::vector<ReplayFrame>& frames() const { return frames_; }
  [[nodiscard]] std::uint32_t source() const { return board_.source(); }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  [[nodiscard]] int bound(std::uint16_t port) const {
    const int number = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const sockaddr_in here = udp_address("test", {.host = host_, .port = port});
    if (number < 0 || bind(number, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) {
      throw std::runtime_error("no socket for the board");
    }
    return number;
  }
  static std::uint16_t port_of(int number) {
    sockaddr_in here{};
    socklen_t size = sizeof here;
    getsockname(number, reinterpret_cast<sockaddr*>(&here), &size);
    return ntohs(here.sin_port);
  }

  void run() {
    while (!stop_) {
      std::array<pollfd, 2> watched{{{frames_port_, POLLIN, 0}, {etherbone_, POLLIN, 0}}};
      const int ready = poll(watched.data(), watched.size(), 10);
      if (replay_.leaving()) {  // as long as nothing came, or at least one question
        replay_.left();
      }
      if (ready > 0 && watched[0].revents != 0) {
        take_frames();
      } else if (ready > 0) {
        answer();
      }
    }
  }

  // All datagrams that wait, as they would come before a question sent after them.
  void take_frames() {
    std::array<std::uint8_t, 2048> bytes{};
    ssize_t count = 0;
    while ((count = recv(frames_port_, bytes.data(), bytes.size(), MSG_DONTWAIT)) >= 0) {
      pass({bytes.begin(), bytes.begin() + count});
    }
  }

  void pass(std::vector<std::uint8_t> datagram) {
    if (random_.chance(percent_)) {
      ++lost_;
      return;
    }
    if (random_.chance(percent_)) {
      late_.push_back(datagram);
    } else {
      arrive(datagram);
    }
    if (random_.chance(percent_)) {
      late_.push_back(std::move(datagram));
    }
    while (!late_.empty() && random_.chance(30)) {
      arrive(late_.front());
      late_.erase(late_.begin());
    }
  }

  void arrive(const std::vector<std::uint8_t>& datagram) {
    const bool runs = registers_.settings().run;
    std::optional<ReplayFrame> whole = replay_.datagram(
        {.came = datagram, .bytes = datagram.size(), .may_send = runs && board_.source() == spec::kSourceReplay});
    if (whole) {
      frames_.push_back(*std::move(whole));
    }
  }

  void answer() {
    std::array<std::uint8_t, 2048> bytes{};
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t count =
        recvfrom(etherbone_, bytes.data(), bytes.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &size);
    if (count < 0) {
      return;
    }
    const std::optional<EtherboneRecord> question = etherbone_record({bytes.data(), static_cast<std::size_t>(count)});
    const std::optional<EtherboneRecord> answer = question ? board_.answer(*question) : std::nullopt;
    if (answer) {
      const std::vector<std::uint8_t> reply = etherbone_bytes(*answer);
      static_cast<void>(
          sendto(etherbone_, reply.data(), reply.size(), 0, reinterpret_cast<const sockaddr*>(&from), size));
    }
  }

  int percent_;
  Random random_;
  std::string host_;
  RegisterFile registers_;
  ReplayModel replay_;
  EtherboneBoard board_;
  std::vector<std::vector<std::uint8_t>> late_;
  std::vector<ReplayFrame> frames_;
  std::uint64_t lost_ = 0;
  std::atomic<bool> stop_ = false;
  int etherbone_;
  int frames_port_;
  std::thread thread_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_REPLAY_BOARD_H
