// The mailbox for writes in the link of a board on the network: each write is performed once, whatever the network does
// (docs/register-reference.md).
#ifndef SELFPROJ_MODEL_WRITE_MAILBOX_H
#define SELFPROJ_MODEL_WRITE_MAILBOX_H

#include <cstdint>
#include <functional>

#include "model/register_file.h"

namespace selfproj {

class WriteMailbox {
 public:
  // An access to the registers of the board.
  using Access = std::function<RegisterAnswer(bool write, std::uint32_t address, std::uint32_t data)>;

  // `ticket`: of the last write performed before.
  explicit WriteMailbox(Access board, std::uint32_t ticket = 0);

  // Accesses from the network. Below 0x100 they go to the board as they are. Behind the last register of the link they
  // are refused.
  RegisterAnswer read(std::uint32_t address);
  RegisterAnswer write(std::uint32_t address, std::uint32_t data);

 private:
  struct Write {
    std::uint32_t ticket = 0;
    std::uint32_t address = 0;
    std::uint32_t value = 0;
  };

  Access board_;
  Write asked_;      // its value is not kept
  Write performed_;  // the last one
  bool refused_ = false;
};

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_WRITE_MAILBOX_H
