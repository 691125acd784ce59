#include "host/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "host/io/file_descriptor.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace fs = std::filesystem;
namespace {

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
    throw UserError(name_, error_text(EISDIR));
  }
  if (fs::exists(status_)) {
    if (access(target_.c_str(), W_OK) != 0) {
      throw UserError(name_, error_text(errno));
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
    throw UserError(name_, error_text(errno));
  }
}

void OutputFile::write(std::string_view text) const {
  if (fs::exists(status_) && !fs::is_regular_file(status_)) {
    FileDescriptor device(open(target_.c_str(), O_WRONLY | O_CLOEXEC));
    if (device.number() < 0 || !write_all(device.number(), text) || !device.close()) {
      throw UserError(name_, error_text(errno));
    }
    return;
  }
  fs::path temporary;
  FileDescriptor file(create_temporary(target_.has_parent_path() ? target_.parent_path() : ".", temporary));
  if (file.number() < 0) {
    throw UserError(name_, error_text(errno));
  }
  const auto mode = static_cast<mode_t>(status_.permissions() & fs::perms::mask);
  const bool done = (!fs::exists(status_) || fchmod(file.number(), mode) == 0) && write_all(file.number(), text) &&
                    fsync(file.number()) == 0 && file.close() && rename(temporary.c_str(), target_.c_str()) == 0;
  if (!done) {
    const int error = errno;
    unlink(temporary.c_str());
    throw UserError(name_, error_text(error));
  }
}

bool OutputFile::is_same_as(const std::string& file) const {
  std::error_code error;
  return fs::equivalent(target_, file, error);
}

}  // namespace selfproj
