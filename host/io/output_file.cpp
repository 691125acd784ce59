#include "host/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "host/io/user_error.h"

namespace selfproj {
namespace fs = std::filesystem;
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

// A file descriptor; `close` tells of errors, the destructor does not.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { static_cast<void>(close()); }

  [[nodiscard]] int number() const { return number_; }

  [[nodiscard]] bool close() {
    const int number = number_;
    number_ = -1;
    return number < 0 || ::close(number) == 0;
  }

 private:
  int number_;
};

[[nodiscard]] bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno != EINTR) {
      return false;
    }
    text.remove_prefix(count < 0 ? 0 : static_cast<std::size_t>(count));
  }
  return true;
}

// Opens a new file in `folder` for writing; its path goes to `path`. The descriptor is -1 where that fails.
int create_temporary(const fs::path& folder, fs::path& path) {
  constexpr int kTries = 100;
  int descriptor = -1;
  for (int i = 0; i < kTries && descriptor < 0; ++i) {
    path = folder / (".selfproj-" + std::to_string(getpid()) + "-" + std::to_string(i) + ".tmp");
    descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);  // less the user's umask
    if (descriptor < 0 && errno != EEXIST) {
      break;
    }
  }
  return descriptor;
}

}  // namespace

OutputFile::OutputFile(const std::string& name) : name_(name), target_(name) {
  std::error_code error;
  status_ = fs::status(target_, error);
  if (fs::is_directory(status_)) {
    throw UserError(name_, reason(EISDIR));
  }
  if (fs::exists(status_)) {
    if (access(target_.c_str(), W_OK) != 0) {
      throw UserError(name_, reason(errno));
    }
    if (!fs::is_regular_file(status_)) {
      return;
    }
    target_ = fs::canonical(target_, error);
    if (error) {
      throw UserError(name_, error.message());
    }
  }
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  const fs::file_status folder_status = fs::status(folder, error);
  if (!fs::exists(folder_status)) {
    throw UserError(name_, "there is no folder " + folder.string());
  }
  if (!fs::is_directory(folder_status)) {
    throw UserError(name_, folder.string() + " is not a folder");
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw UserError(name_, reason(errno));
  }
}

void OutputFile::write(std::string_view text) const {
  if (fs::exists(status_) && !fs::is_regular_file(status_)) {
    Descriptor device(open(target_.c_str(), O_WRONLY | O_CLOEXEC));
    if (device.number() < 0 || !write_all(device.number(), text) || !device.close()) {
      throw UserError(name_, reason(errno));
    }
    return;
  }
  fs::path temporary;
  Descriptor file(create_temporary(target_.has_parent_path() ? target_.parent_path() : ".", temporary));
  if (file.number() < 0) {
    throw UserError(name_, reason(errno));
  }
  const auto mode = static_cast<mode_t>(status_.permissions() & fs::perms::mask);
  const bool done = (!fs::exists(status_) || fchmod(file.number(), mode) == 0) && write_all(file.number(), text) &&
                    fsync(file.number()) == 0 && file.close() && rename(temporary.c_str(), target_.c_str()) == 0;
  if (!done) {
    const int error = errno;
    unlink(temporary.c_str());
    throw UserError(name_, reason(error));
  }
}

bool OutputFile::is_same_as(const std::string& file) const {
  std::error_code error;
  return fs::equivalent(target_, file, error);
}

}  // namespace selfproj
