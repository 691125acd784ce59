#include "host/driver/litepcie_port.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/device_port.h"
#include "host/driver/litepcie_interface.h"
#include "host/driver/register_port.h"
#include "host/files/file_descriptor.h"
#include "host/files/user_error.h"
#include "model/spec/generated/register_table.h"

namespace selfproj {
namespace {

class LitePciePort final : public RegisterPort {
 public:
  LitePciePort(std::unique_ptr<DevicePort> port, std::string uri) : port_(std::move(port)), uri_(std::move(uri)) {}

  std::vector<std::uint32_t> read(std::span<const std::uint32_t> addresses) override {
    std::vector<std::uint32_t> words;
    words.reserve(addresses.size());
    for (const std::uint32_t address : addresses) {
      words.push_back(access({.address = place(address), .value = 0, .write = 0}));
    }
    return words;
  }

  Written write(std::uint32_t address, std::uint32_t value) override {
    access({.address = place(address), .value = value, .write = 1});
    return Written::unknown;
  }

  [[nodiscard]] const std::string& uri() const override { return uri_; }

 private:
  // The driver does not check addresses: those beyond the board's registers would be LitePCIe's own.
  [[nodiscard]] std::uint32_t place(std::uint32_t address) const {
    if (address % 4 != 0 || address > spec::kRegisters.back().address) {
      throw UserError(uri_, "has no register at " + std::to_string(address));
    }
    return litepcie::kBoardRegisters + address;
  }

  std::uint32_t access(litepcie::Access one) {
    const int error = port_->control(litepcie::kAccess, &one);
    if (error != 0) {
      throw UserError(uri_, "the board's registers cannot be reached: " + error_text(error));
    }
    return one.value;
  }

  std::unique_ptr<DevicePort> port_;
  std::string uri_;
};

}  // namespace

std::unique_ptr<RegisterPort> make_litepcie_port(const std::string& path) {
  const std::string uri = "litepcie:" + path;
  return make_litepcie_port(open_device_port(path, uri), uri);
}

std::unique_ptr<RegisterPort> make_litepcie_port(std::unique_ptr<DevicePort> port, const std::string& uri) {
  return std::make_unique<LitePciePort>(std::move(port), uri);
}

}  // namespace selfproj
