#include "host/files/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "host/files/file_descriptor.h"
#include "host/files/run_files.h"
#include "host/files/signals_held.h"
#include "host/files/temporary.h"
#include "host/files/user_error.h"

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

// A file that is being written: a temporary one that takes the target's place at the end, or the device or pipe itself.
class OutputStream::Part {
 public:
  explicit Part(const OutputFile& file) : file_(file) {
    if (fs::exists(file.status_) && !fs::is_regular_file(file.status_)) {
      device_.reset(open(file.target_.c_str(), O_WRONLY | O_CLOEXEC));
      must(device_.number() >= 0);
      return;
    }
    temporary_.emplace(writable_parent(file.name_, file.target_), Temporary::Kind::file);
  }

  void append(std::string_view text) { must(write_all(descriptor().number(), text)); }

  void commit() {
    if (!temporary_) {
      must(device_.close());
      return;
    }
    const auto mode = static_cast<mode_t>(file_.status_.permissions() & fs::perms::mask);
    const int number = descriptor().number();
    must((!fs::exists(file_.status_) || fchmod(number, mode) == 0) && fsync(number) == 0);
    const SignalsHeld held;
    std::error_code error;
    MadeFolders parents(parent_of(file_.target_), error);
    if (error) {
      throw std::system_error(error);
    }
    must(rename(temporary_->path().c_str(), file_.target_.c_str()) == 0);
    temporary_->keep();
    parents.keep();
  }

 private:
  static void must(bool done) {
    if (!done) {
      throw std::system_error(errno, std::generic_category());
    }
  }
  FileDescriptor& descriptor() { return temporary_ ? temporary_->descriptor() : device_; }

  const OutputFile& file_;
  std::optional<Temporary> temporary_;  // empty: a device
  FileDescriptor device_{-1};
};

// What cannot be done is the user's error, and names the file.
template <class Act>
auto OutputStream::guarded(Act act) const {
  try {
    return act();
  } catch (const std::system_error& error) {
    throw UserError(file_.name(), error.code().message());
  }
}

OutputStream::OutputStream(const OutputFile& file)
    : file_(file), part_(guarded([&] { return std::make_unique<Part>(file); })) {}

OutputStream::~OutputStream() = default;

void OutputStream::append(std::string_view text) {
  guarded([&] { part_->append(text); });
}

void OutputStream::commit() {
  guarded([&] { part_->commit(); });
}

void OutputFile::write(std::string_view text) const {
  OutputStream stream(*this);
  stream.append(text);
  stream.commit();
}

}  // namespace selfproj
