#include "host/driver/register_port.h"

#include <endian.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "host/driver/bus_guard.h"
#include "host/files/file_descriptor.h"
#include "host/files/run_files.h"
#include "model/spec/generated/register_table.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
namespace {

constexpr std::size_t kBarBytes = spec::kRegisters.back().address + 4;

class BarPort final : public RegisterPort {
 public:
  BarPort(int descriptor, std::size_t offset, const std::string& uri) : uri_(uri) {
    struct stat status {};
    if (fstat(descriptor, &status) != 0) {
      throw UserError(uri, files::error_text(errno));
    }
    if (S_ISREG(status.st_mode) && static_cast<std::uint64_t>(status.st_size) < offset + kBarBytes) {
      throw UserError(uri,
                      "is too short for the registers: " + std::to_string(offset + kBarBytes) + " bytes are needed");
    }
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t begin = offset / page * page;
    bytes_ = offset - begin + kBarBytes;
    void* const mapped =
        mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, static_cast<off_t>(begin));
    if (mapped == MAP_FAILED) {
      throw UserError(uri, "cannot be mapped: " + files::error_text(errno));
    }
    mapped_ = static_cast<std::uint8_t*>(mapped);
    registers_ = mapped_ + (offset - begin);
    guard_mapping(mapped_, bytes_);
  }
  BarPort(const BarPort&) = delete;
  BarPort& operator=(const BarPort&) = delete;
  ~BarPort() override {
    unguard_mapping(mapped_);
    munmap(mapped_, bytes_);
  }

  std::vector<std::uint32_t> read(std::span<const std::uint32_t> addresses) override {
    std::vector<std::uint32_t> words;
    words.reserve(addresses.size());
    for (const std::uint32_t address : addresses) {
      words.push_back(le32toh(*word(address)));
    }
    return words;
  }

  Written write(std::uint32_t address, std::uint32_t value) override {
    *word(address) = htole32(value);
    return Written::unknown;
  }

  [[nodiscard]] const std::string& uri() const override { return uri_; }

 private:
  // One access of 32 bits each, in order: the compiler may not join, repeat or leave out any.
  [[nodiscard]] volatile std::uint32_t* word(std::uint32_t address) const {
    if (address % 4 != 0 || address + 4 > kBarBytes) {
      throw UserError(uri_, "has no register at " + std::to_string(address));
    }
    return reinterpret_cast<volatile std::uint32_t*>(registers_ + address);
  }

  std::string uri_;
  std::uint8_t* mapped_ = nullptr;
  std::size_t bytes_ = 0;
  std::uint8_t* registers_ = nullptr;
};

// The number after the last '+', if it is one.
std::size_t offset_of(const std::string& place, std::string& path) {
  path = place;
  const std::size_t plus = place.rfind('+');
  if (plus == std::string::npos) {
    return 0;
  }
  std::string_view text = std::string_view(place).substr(plus + 1);
  int base = 10;
  if (text.starts_with("0x")) {
    text.remove_prefix(2);
    base = 16;
  }
  std::uint64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  constexpr std::uint64_t kMost = std::uint64_t{1} << 40U;
  if (error != std::errc() || stop != text.data() + text.size() || value % 4 != 0 || value > kMost) {
    throw UserError("bar:" + place, "'" + place.substr(plus + 1) + "' is no offset: a multiple of 4, up to 2^40");
  }
  path = place.substr(0, plus);
  return static_cast<std::size_t>(value);
}

}  // namespace

std::unique_ptr<RegisterPort> make_bar_port(const std::string& place) {
  const std::string uri = "bar:" + place;
  std::string path;
  const std::size_t offset = offset_of(place, path);
  const files::FileDescriptor file(open(path.c_str(), O_RDWR | O_CLOEXEC | O_SYNC | O_NONBLOCK));
  if (file.number() < 0) {
    throw UserError(uri, files::error_text(errno));
  }
  files::note_input(path);
  return std::make_unique<BarPort>(file.number(), offset, uri);
}

std::unique_ptr<RegisterPort> make_bar_port(int descriptor, const std::string& uri) {
  return std::make_unique<BarPort>(descriptor, 0, uri);
}

}  // namespace selfproj::driver
