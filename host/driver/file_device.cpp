#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "host/driver/clock.h"
#include "host/driver/device_kinds.h"
#include "host/files/file_descriptor.h"
#include "host/files/run_files.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"
#include "selfproj/driver/packet_reader.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
namespace {

constexpr std::chrono::milliseconds kRetryPause(1);  // after an error of a character device

class FileDevice final : public TalliedDevice {
 public:
  FileDevice(const std::string& path, const DeviceOptions& options)
      : TalliedDevice("file:" + path, options),
        path_(path),
        // Without O_NONBLOCK, opening a pipe would wait for its writer.
        file_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)),
        reader_(counters_, options.buffer_bytes) {
    struct stat status {};
    if (file_.number() < 0 || fstat(file_.number(), &status) != 0) {
      throw UserError(path, files::error_text(errno));
    }
    if (S_ISDIR(status.st_mode)) {
      throw UserError(path, files::error_text(EISDIR));
    }
    regular_ = S_ISREG(status.st_mode);
    character_ = S_ISCHR(status.st_mode);
    files::note_input(path);
  }

  Next next(model::PacketView& packet, std::chrono::nanoseconds timeout) override {
    const std::int64_t started = now_ns();
    for (bool looked = false;; looked = true) {
      while (reader_.next(packet)) {
        if (tally_.deliver(packet)) {
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

 private:
  // Returns whether there is data or an end to read. Waits according to the policy, up to `timeout` after the start of
  // next(), which was `waited` ago.
  [[nodiscard]] bool ready(std::int64_t waited, std::int64_t timeout) const {
    const bool readable = files::wait_readable(file_.number(), options_.polls(waited) ? 0 : timeout - waited);
    if (!readable) {
      relax();
    }
    return readable;
  }

  void read_some() {
    const std::span<std::uint8_t> room = reader_.room();
    const ssize_t count = read(file_.number(), room.data(), room.size());
    arrival_ns_ = now_ns();
    if (count > 0) {
      reader_.added(static_cast<std::size_t>(count));
    } else if (count == 0) {
      ended_ = true;
      reader_.finish();
    } else if (errno != EINTR && errno != EAGAIN) {
      if (!character_) {
        throw UserError(path_, files::error_text(errno));
      }
      // It is not known what the device lost. So give up the current packet and look for the next whole one.
      ++counters_.read_errors;
      reader_.restart();
      std::this_thread::sleep_for(kRetryPause);
    }
  }

  std::string path_;
  files::FileDescriptor file_;
  PacketStreamReader reader_;
  bool regular_ = false;
  bool character_ = false;
  bool ended_ = false;
};

}  // namespace

std::unique_ptr<Device> make_file_device(const std::string& path, const DeviceOptions& options) {
  return std::make_unique<FileDevice>(path, options);
}

}  // namespace selfproj::driver
