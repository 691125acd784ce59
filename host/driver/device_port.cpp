#include "host/driver/device_port.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/files/file_descriptor.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
namespace {

class KernelDevicePort final : public DevicePort {
 public:
  KernelDevicePort(const std::string& path, const std::string& uri)
      : file_(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
    if (file_.number() < 0) {
      throw UserError(uri, files::error_text(errno));
    }
  }

  ~KernelDevicePort() override {
    for (const auto& [bytes, size] : mapped_) {
      munmap(bytes, size);
    }
  }

  int control(unsigned long request, void* argument) override {
    for (;;) {
      if (::ioctl(file_.number(), request, argument) == 0) {
        return 0;
      }
      if (errno != EINTR) {
        return errno;
      }
    }
  }

  const std::uint8_t* map(std::size_t bytes, std::int64_t offset) override {
    void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_.number(), offset);
    if (memory == MAP_FAILED) {
      return nullptr;
    }
    mapped_.emplace_back(memory, bytes);
    return static_cast<const std::uint8_t*>(memory);
  }

  bool wait(std::chrono::nanoseconds timeout) override { return files::wait_readable(file_.number(), timeout.count()); }

 private:
  files::FileDescriptor file_;
  std::vector<std::pair<void*, std::size_t>> mapped_;
};

}  // namespace

std::unique_ptr<DevicePort> open_device_port(const std::string& path, const std::string& uri) {
  return std::make_unique<KernelDevicePort>(path, uri);
}

}  // namespace selfproj::driver
