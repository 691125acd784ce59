#include "host/driver/file_device.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <memory>
#include <span>
#include <string>
#include <system_error>

#include "host/driver/clock.h"
#include "host/driver/counters.h"
#include "host/driver/device.h"
#include "host/driver/packet_reader.h"
#include "host/driver/packet_tally.h"
#include "host/files/run_files.h"
#include "host/files/user_error.h"

namespace selfproj {
namespace {

constexpr std::int64_t kRetryNs = 1'000'000;  // after an error of a character device

std::string reason(int error) { return std::generic_category().message(error); }

class FileDevice final : public Device {
 public:
  FileDevice(const std::string& path, const DeviceOptions& options)
      : path_(path),
        uri_("file:" + path),
        options_(options),
        reader_(counters_, options.buffer_bytes),
        tally_(counters_) {
    struct stat status {};
    // Without O_NONBLOCK, opening a pipe would wait for its writer.
    descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0 || fstat(descriptor_, &status) != 0) {
      fail(errno);
    }
    if (S_ISDIR(status.st_mode)) {
      fail(EISDIR);
    }
    regular_ = S_ISREG(status.st_mode);
    try {
      note_input(path);
    } catch (const UserError&) {
      close_file();
      throw;
    }
    character_ = S_ISCHR(status.st_mode);
  }
  FileDevice(const FileDevice&) = delete;
  FileDevice& operator=(const FileDevice&) = delete;
  ~FileDevice() override { close_file(); }

  Next next(PacketView& packet, std::chrono::nanoseconds timeout) override {
    const std::int64_t started = now_ns();
    for (bool looked = false;; looked = true) {
      while (reader_.next(packet)) {
        if (tally_.accept(packet.header)) {
          ++counters_.delivered;
          counters_.flagged += packet.status != 0 ? 1 : 0;
          return Next::packet;
        }
      }
      if (ended_) {
        return Next::end;
      }
      // A regular file never makes the reader wait, and is read even if the time is up.
      const std::int64_t waited = now_ns() - started;
      if (!regular_ && looked && waited >= timeout.count()) {
        return Next::timeout;
      }
      if (regular_ || ready(waited, timeout.count())) {
        read_some();
      }
    }
  }

  void release() override {}  // the buffer moves only within next()

  [[nodiscard]] std::int64_t arrival_ns() const override { return arrival_ns_; }
  [[nodiscard]] Counters counters() const override { return counters_; }
  [[nodiscard]] const std::string& uri() const override { return uri_; }

 private:
  void close_file() const {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
  }

  [[noreturn]] void fail(int error) const {
    close_file();
    throw UserError(path_, reason(error));
  }

  // Returns whether there is data or an end to read. Waits according to the policy, up to `timeout` after the start of
  // next(), which was `waited` ago.
  [[nodiscard]] bool ready(std::int64_t waited, std::int64_t timeout) const {
    std::int64_t wait = std::max<std::int64_t>(timeout - waited, 0);
    if (options_.wait == Wait::polling ||
        (options_.wait == Wait::polling_then_blocking && waited < options_.spin.count())) {
      wait = 0;
    }
    constexpr std::int64_t kSecond = 1'000'000'000;
    const timespec limit{static_cast<std::time_t>(wait / kSecond), static_cast<long>(wait % kSecond)};
    pollfd watched{descriptor_, POLLIN, 0};
    const int answer = ppoll(&watched, 1, &limit, nullptr);
    if (answer == 0) {
      relax();
    }
    return answer > 0;
  }

  void read_some() {
    const std::span<std::uint8_t> room = reader_.room();
    const ssize_t count = read(descriptor_, room.data(), room.size());
    arrival_ns_ = now_ns();
    if (count > 0) {
      reader_.added(static_cast<std::size_t>(count));
    } else if (count == 0) {
      ended_ = true;
      reader_.finish();
    } else if (errno != EINTR && errno != EAGAIN) {
      if (!character_) {
        throw UserError(path_, reason(errno));
      }
      // It is not known what the device lost. So give up the current packet and look for the next whole one.
      ++counters_.read_errors;
      reader_.restart();
      const timespec pause{0, kRetryNs};
      nanosleep(&pause, nullptr);
    }
  }

  std::string path_;
  std::string uri_;
  DeviceOptions options_;
  Counters counters_;
  PacketStreamReader reader_;
  PacketTally tally_;
  int descriptor_ = -1;
  bool regular_ = false;
  bool character_ = false;
  bool ended_ = false;
  std::int64_t arrival_ns_ = 0;
};

}  // namespace

std::unique_ptr<Device> make_file_device(const std::string& path, const DeviceOptions& options) {
  return std::make_unique<FileDevice>(path, options);
}

}  // namespace selfproj
