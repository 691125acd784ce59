// Ways to the registers of a board: words at byte addresses. control.h gives them names.
#ifndef SELFPROJ_HOST_DRIVER_REGISTER_PORT_H
#define SELFPROJ_HOST_DRIVER_REGISTER_PORT_H

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selfproj::driver {

enum class Written : std::uint8_t {
  applied,  // the board has the value
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

  // The word at one address.
  [[nodiscard]] std::uint32_t word(std::uint32_t address) { return read({&address, 1}).front(); }

  // Writes a word once, or not at all. Throws UserError with the URI if it is not known whether the board got it.
  virtual Written write(std::uint32_t address, std::uint32_t value) = 0;

  // The URI with which it was opened, such as "udp:192.168.1.50".
  [[nodiscard]] virtual const std::string& uri() const = 0;
};

// Registers in a file that is mapped into memory, little endian: /dev/xdma0_user, /dev/uio0, the resource file of a
// PCI device, or an ordinary file. `place` is PATH, or PATH+OFFSET where the registers begin at a byte OFFSET, decimal
// or 0x..., a multiple of 4. A write is posted, so its answer is Written::unknown. Throws UserError if the file cannot
// be opened and mapped for reading and writing, or is an ordinary one that is too short. If it is shortened later, the
// registers read as 0.
std::unique_ptr<RegisterPort> make_bar_port(const std::string& place);

// Registers at an open descriptor, which is mapped and then no longer needed. For memfd_create and tests.
std::unique_ptr<RegisterPort> make_bar_port(int descriptor, const std::string& uri);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_REGISTER_PORT_H
