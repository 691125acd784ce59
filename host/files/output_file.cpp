#include "host/files/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "host/files/run_files.h"
#include "host/files/signals_held.h"
#include "selfproj/files/user_error.h"

namespace selfproj::files {
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

void OutputStream::must(bool done) const {
  if (!done) {
    throw UserError(file_.name(), error_text(errno));
  }
}

OutputStream::OutputStream(const OutputFile& file) : file_(file) {
  if (fs::exists(file.status_) && !fs::is_regular_file(file.status_)) {
    device_.reset(open(file.target_.c_str(), O_WRONLY | O_CLOEXEC));
    must(device_.number() >= 0);
    return;
  }
  temporary_.emplace(file.name_, writable_parent(file.name_, file.target_), Temporary::Kind::file);
}

void OutputStream::append(std::string_view text) {
  must(write_all((temporary_ ? temporary_->descriptor() : device_).number(), text));
}

void OutputStream::commit() {
  if (!temporary_) {
    must(device_.close());
    return;
  }
  const auto mode = static_cast<mode_t>(file_.status_.permissions() & fs::perms::mask);
  const int number = temporary_->descriptor().number();
  must((!fs::exists(file_.status_) || fchmod(number, mode) == 0) && fsync(number) == 0);
  const SignalsHeld held;
  std::error_code error;
  MadeFolders parents(parent_of(file_.target_), error);
  if (error) {
    throw UserError(file_.name(), error.message());
  }
  must(rename(temporary_->path().c_str(), file_.target_.c_str()) == 0);
  temporary_->keep();
  parents.keep();
}

void OutputStream::commit_first(std::uint64_t bytes) {
  if (temporary_) {
    must(ftruncate(temporary_->descriptor().number(), static_cast<off_t>(bytes)) == 0);
  }
  commit();
}

void OutputFile::write(std::string_view text) const {
  OutputStream stream(*this);
  stream.append(text);
  stream.commit();
}

}  // namespace selfproj::files
