#include "host/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "host/io/file_descriptor.h"
#include "host/io/output_parents.h"
#include "host/io/run_files.h"
#include "host/io/signals_held.h"
#include "host/io/temporary.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace fs = std::filesystem;

OutputFile::OutputFile(const std::string& name) : name_(name), target_(name) {
  if (name.empty()) {
    throw UserError("output file", "the name is empty");
  }
  std::error_code error;
  status_ = fs::status(target_, error);
  if (fs::is_directory(status_) || !target_.has_filename()) {
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
  static_cast<void>(writable_parent(name_, target_));
  note_output(name_, target_);
}

void OutputFile::write(std::string_view text) const {
  if (fs::exists(status_) && !fs::is_regular_file(status_)) {
    FileDescriptor device(open(target_.c_str(), O_WRONLY | O_CLOEXEC));
    if (device.number() < 0 || !write_all(device.number(), text) || !device.close()) {
      throw UserError(name_, error_text(errno));
    }
    return;
  }
  try {
    Temporary temporary(writable_parent(name_, target_), Temporary::Kind::file);
    FileDescriptor& file = temporary.descriptor();
    const auto mode = static_cast<mode_t>(status_.permissions() & fs::perms::mask);
    if ((fs::exists(status_) && fchmod(file.number(), mode) != 0) || !write_all(file.number(), text) ||
        fsync(file.number()) != 0) {
      throw std::system_error(errno, std::generic_category());
    }
    const SignalsHeld held;
    std::error_code error;
    MadeFolders parents(parent_of(target_), error);
    if (error) {
      throw std::system_error(error);
    }
    if (rename(temporary.path().c_str(), target_.c_str()) != 0) {
      throw std::system_error(errno, std::generic_category());
    }
    temporary.keep();
    parents.keep();
  } catch (const std::system_error& error) {
    throw UserError(name_, error.code().message());
  }
}

}  // namespace selfproj
