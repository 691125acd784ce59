#include "sim/board/etherbone_board.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/types.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/driver/etherbone.h"
#include "host/driver/udp_socket.h"
#include "model/write_mailbox.h"
#include "selfproj/files/user_error.h"

namespace selfproj::sim {

EtherboneBoard::EtherboneBoard(const model::WriteMailbox::Access& registers, bool mailbox, std::uint32_t ticket,
                               const model::VideoBuild& video, model::ReplayModel* replay)
    : registers_(registers) {
  if (mailbox) {
    mailbox_.emplace(registers, ticket, video, replay);
  }
}

std::optional<driver::EtherboneRecord> EtherboneBoard::answer(const driver::EtherboneRecord& question) {
  if (question.probe) {
    return driver::EtherboneRecord{.probe_answer = true};
  }
  std::uint32_t address = question.write_address;
  for (const std::uint32_t value : question.writes) {
    static_cast<void>(mailbox_ ? mailbox_->write(address, value) : registers_(true, address, value));
    address += 4;
  }
  if (question.reads.empty()) {
    return std::nullopt;
  }
  driver::EtherboneRecord answer{.write_address = question.tag};
  for (const std::uint32_t from : question.reads) {
    answer.writes.push_back((mailbox_ ? mailbox_->read(from) : registers_(false, from, 0)).data);
  }
  return answer;
}

EtherboneServer::EtherboneServer(const std::string& name, const std::string& place,
                                 const model::WriteMailbox::Access& registers)
    : board_(registers), socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const sockaddr_in here = driver::udp_address(name, driver::udp_place(name, place, driver::kEtherbonePort));
  if (socket_.number() < 0 || bind(socket_.number(), reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) {
    throw UserError(name, files::error_text(errno));
  }
  thread_ = std::thread([this] { run(); });
}

EtherboneServer::~EtherboneServer() {
  stop_ = true;
  thread_.join();
}

void EtherboneServer::run() {
  constexpr int kGlanceMs = 20;
  std::array<std::uint8_t, 1500> bytes{};
  while (!stop_) {
    pollfd watched{socket_.number(), POLLIN, 0};
    if (poll(&watched, 1, kGlanceMs) <= 0) {
      continue;
    }
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t count =
        recvfrom(socket_.number(), bytes.data(), bytes.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &size);
    if (count < 0) {
      continue;
    }
    const std::optional<driver::EtherboneRecord> question =
        driver::etherbone_record({bytes.data(), static_cast<std::size_t>(count)});
    const std::optional<driver::EtherboneRecord> answer = question ? board_.answer(*question) : std::nullopt;
    if (answer) {
      const std::vector<std::uint8_t> reply = driver::etherbone_bytes(*answer);
      static_cast<void>(sendto(socket_.number(), reply.data(), reply.size(), MSG_DONTWAIT,
                               reinterpret_cast<const sockaddr*>(&from), size));
    }
  }
}

}  // namespace selfproj::sim
