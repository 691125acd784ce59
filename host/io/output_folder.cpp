#include "host/io/output_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "host/io/file_descriptor.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace fs = std::filesystem;
namespace {

// The folder that holds it: "." where the name has no other.
fs::path parent_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

// Takes a file that is on disk to the end of its way: what was written is safe against a loss of power.
bool synchronize(const fs::path& path) {
  FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  return file.number() >= 0 && fsync(file.number()) == 0 && file.close();
}

// Puts the file `fresh` in the place of `target`, which becomes `old` where it exists. Where that fails `target` is as
// it was, and `error` says why.
bool replace(const fs::path& target, const fs::path& fresh, const fs::path& old, std::error_code& error) {
  if (fs::is_directory(fs::symlink_status(target, error))) {
    error = std::make_error_code(std::errc::is_a_directory);
    return false;
  }
  fs::rename(target, old, error);
  if (error && error != std::errc::no_such_file_or_directory) {
    return false;
  }
  fs::rename(fresh, target, error);
  if (error) {
    std::error_code ignored;
    fs::rename(old, target, ignored);
    return false;
  }
  return true;
}

}  // namespace

OutputFolder::OutputFolder(const std::string& name) : name_(name), target_(name) {
  if (name.empty()) {
    throw UserError("output folder", "the name is empty");
  }
  if (!target_.has_filename()) {  // "results/"
    target_ = target_.parent_path();
  }
  std::error_code error;
  const fs::file_status status = fs::status(target_, error);
  if (fs::exists(status) && !fs::is_directory(status)) {
    throw UserError(name_, "is there and not a folder");
  }
  exists_ = fs::is_directory(status);
  if (!exists_ && status.type() != fs::file_type::not_found) {
    throw UserError(name_, error.message());
  }
  const fs::path writable = exists_ ? target_ : parent_of(target_);
  const fs::file_status writable_status = fs::status(writable, error);
  if (!fs::exists(writable_status)) {
    throw UserError(name_, "there is no folder " + writable.string());
  }
  if (!fs::is_directory(writable_status)) {
    throw UserError(name_, writable.string() + " is not a folder");
  }
  if (access(writable.c_str(), W_OK | X_OK) != 0) {
    throw UserError(name_, error_text(errno));
  }
}

OutputFolder::~OutputFolder() {
  if (!staging_.empty()) {
    std::error_code ignored;
    fs::remove_all(staging_, ignored);
  }
}

void OutputFolder::create_staging() {
  constexpr int kTries = 100;
  const fs::path folder = exists_ ? target_ : parent_of(target_);  // so that moving is renaming, on one file system
  for (int i = 0; i < kTries; ++i) {
    const fs::path path = folder / (".selfproj-" + std::to_string(getpid()) + "-" + std::to_string(i) + ".tmp");
    if (mkdir(path.c_str(), 0777) == 0) {  // less the user's umask
      staging_ = path;
      return;
    }
    if (errno != EEXIST) {
      break;
    }
  }
  throw UserError(name_, error_text(errno));
}

void OutputFolder::append(const std::string& file, std::string_view text) {
  if (staging_.empty()) {
    create_staging();
  }
  if (const fs::path inner = fs::path(file).parent_path(); !inner.empty()) {
    if (exists_) {
      throw UserError(name_, "is there already; a new folder is needed, as there will be folders within");
    }
    std::error_code error;
    fs::create_directories(staging_ / inner, error);  // where that fails, so does opening the file
  }
  FileDescriptor output(open((staging_ / file).c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (output.number() < 0 || !write_all(output.number(), text) || !output.close()) {
    throw UserError(target_ / file, error_text(errno));
  }
  if (std::find(files_.begin(), files_.end(), file) == files_.end()) {
    files_.push_back(file);
  }
}

void OutputFolder::commit() {
  if (staging_.empty()) {
    create_staging();
  }
  for (const std::string& file : files_) {
    if (!synchronize(staging_ / file)) {
      throw UserError(target_ / file, error_text(errno));
    }
  }
  if (exists_) {
    move_in();
  } else if (rename(staging_.c_str(), target_.c_str()) != 0) {
    throw UserError(name_, error_text(errno));
  }
  if (exists_) {
    std::error_code ignored;
    fs::remove_all(staging_, ignored);
  }
  staging_.clear();
}

// File by file, each old one kept until the last new one is in place.
void OutputFolder::move_in() {
  std::error_code error;
  std::size_t done = 0;
  while (done < files_.size() &&
         replace(target_ / files_[done], staging_ / files_[done], staging_ / (".old-" + files_[done]), error)) {
    ++done;
  }
  if (done == files_.size()) {
    return;
  }
  const fs::path failed = target_ / files_[done];
  while (done > 0) {
    --done;
    std::error_code ignored;
    fs::remove(target_ / files_[done], ignored);
    fs::rename(staging_ / (".old-" + files_[done]), target_ / files_[done], ignored);
  }
  throw UserError(failed, error.message());
}

}  // namespace selfproj
