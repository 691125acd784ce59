// The registers of the link of a board on the network (docs/register-reference.md): the mailbox for writes, by which
// each write is performed once, whatever the network does; and the source of the video.
#ifndef SELFPROJ_MODEL_WRITE_MAILBOX_H
#define SELFPROJ_MODEL_WRITE_MAILBOX_H

#include <cstdint>
#include <functional>

#include "model/register_file.h"
#include "model/replay.h"
#include "model/spec/generated/register_table.h"

namespace selfproj::model {

// Where a build can take its video from.
struct VideoBuild {
  std::uint32_t sources = 1U << spec::kSourceCamera;  // bit i: source i of the register `source`
  ReplaySize replay = {};
};

class WriteMailbox {
 public:
  // An access to the registers of the board.
  using Access = std::function<RegisterAnswer(bool write, std::uint32_t address, std::uint32_t data)>;

  // `ticket`: of the last write performed before. `replay`: of a build that has it.
  explicit WriteMailbox(Access board, std::uint32_t ticket = 0, const VideoBuild& video = {},
                        ReplayModel* replay = nullptr);

  // Accesses from the network. Below 0x100 they go to the board as they are. Behind the last register of the link they
  // are refused.
  RegisterAnswer read(std::uint32_t address);
  RegisterAnswer write(std::uint32_t address, std::uint32_t data);

  [[nodiscard]] std::uint32_t source() const { return source_; }

 private:
  struct Write {
    std::uint32_t ticket = 0;
    std::uint32_t address = 0;
    std::uint32_t value = 0;
  };

  // A write of the mailbox. Returns whether it is refused.
  bool refuses(std::uint32_t address, std::uint32_t data);

  Access board_;
  VideoBuild video_;
  ReplayModel* replay_;
  std::uint32_t source_ = spec::kSourceCamera;
  std::uint32_t session_ = 0;  // of replay
  Write asked_;                // its value is not kept
  Write performed_;            // the last one
  bool refused_ = false;
};

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_WRITE_MAILBOX_H
