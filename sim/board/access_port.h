// The registers of a simulated board: its AXI4-Lite port, with the answers of the board.
#ifndef SELFPROJ_SIM_BOARD_ACCESS_PORT_H
#define SELFPROJ_SIM_BOARD_ACCESS_PORT_H

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/register_port.h"
#include "model/register_file.h"
#include "selfproj/files/user_error.h"

namespace selfproj::sim {

class AccessPort final : public driver::RegisterPort {
 public:
  // One access on the bus.
  using Access = std::function<model::RegisterAnswer(bool write, std::uint32_t address, std::uint32_t data)>;

  explicit AccessPort(Access access) : access_(std::move(access)) {}

  std::vector<std::uint32_t> read(std::span<const std::uint32_t> addresses) override {
    std::vector<std::uint32_t> words;
    words.reserve(addresses.size());
    for (const std::uint32_t address : addresses) {
      const model::RegisterAnswer answer = access_(false, address, 0);
      if (answer.error) {
        throw UserError(uri_, "the board has no register at " + std::to_string(address));
      }
      words.push_back(answer.data);
    }
    return words;
  }

  driver::Written write(std::uint32_t address, std::uint32_t value) override {
    return access_(true, address, value).error ? driver::Written::refused : driver::Written::applied;
  }

  [[nodiscard]] const std::string& uri() const override { return uri_; }

 private:
  std::string uri_ = "sim:";
  Access access_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_ACCESS_PORT_H
