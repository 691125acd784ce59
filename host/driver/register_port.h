// A way to the registers of a board: words at byte addresses. control.h gives them names.
#ifndef SELFPROJ_HOST_DRIVER_REGISTER_PORT_H
#define SELFPROJ_HOST_DRIVER_REGISTER_PORT_H

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace selfproj {

enum class Written : std::uint8_t {
  taken,    // the board has taken the value
  refused,  // the board has refused it, and nothing has changed
  unknown,  // this way brings no answer: read the register to see
};

// For one thread at a time.
class RegisterPort {
 public:
  RegisterPort() = default;
  RegisterPort(const RegisterPort&) = delete;
  RegisterPort& operator=(const RegisterPort&) = delete;
  virtual ~RegisterPort() = default;

  // The words at these addresses, read one directly after the other. Throws UserError with the URI if no answer comes,
  // or if the board says that there is no such register. (Not every way can bring this answer; the word is then 0 or
  // anything else.)
  [[nodiscard]] virtual std::vector<std::uint32_t> read(std::span<const std::uint32_t> addresses) = 0;

  // Writes a word once, or not at all. Throws UserError with the URI if it is not known whether the board got it.
  virtual Written write(std::uint32_t address, std::uint32_t value) = 0;

  // The URI with which it was opened, such as "udp:192.168.1.50".
  [[nodiscard]] virtual const std::string& uri() const = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_REGISTER_PORT_H
