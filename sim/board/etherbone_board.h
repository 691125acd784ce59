// A board on the network as Etherbone sees it.
#ifndef SELFPROJ_SIM_BOARD_ETHERBONE_BOARD_H
#define SELFPROJ_SIM_BOARD_ETHERBONE_BOARD_H

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "host/driver/etherbone.h"
#include "host/files/file_descriptor.h"
#include "model/write_mailbox.h"

namespace selfproj::sim {

// The registers of a board behind its link.
class EtherboneBoard {
 public:
  // `mailbox`: whether the link has the mailbox for writes, and the registers beside it. The rest is that of
  // WriteMailbox.
  explicit EtherboneBoard(const model::WriteMailbox::Access& registers, bool mailbox = true, std::uint32_t ticket = 0,
                          const model::VideoBuild& video = {}, model::ReplayModel* replay = nullptr);

  // Does what a record asks for. Returns the answer, if one belongs to it.
  std::optional<driver::EtherboneRecord> answer(const driver::EtherboneRecord& question);

  // The register `source`.
  [[nodiscard]] std::uint32_t source() const { return mailbox_ ? mailbox_->source() : spec::kSourceCamera; }

 private:
  model::WriteMailbox::Access registers_;
  std::optional<model::WriteMailbox> mailbox_;
};

// A thread that answers in the place of a board.
class EtherboneServer {
 public:
  // At `place`, ADDRESS or ADDRESS:PORT of this machine, port kEtherbonePort unless given. `name` is what the user
  // gave, for errors. `registers` is called by the thread. Throws UserError.
  EtherboneServer(const std::string& name, const std::string& place, const model::WriteMailbox::Access& registers);
  EtherboneServer(const EtherboneServer&) = delete;
  EtherboneServer& operator=(const EtherboneServer&) = delete;
  ~EtherboneServer();

 private:
  void run();

  EtherboneBoard board_;
  files::FileDescriptor socket_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_ETHERBONE_BOARD_H
