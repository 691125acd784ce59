#include "host/files/output_folder.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <system_error>

#include "host/files/file_descriptor.h"
#include "host/files/run_files.h"
#include "host/files/signals_held.h"
#include "host/files/temporary.h"
#include "selfproj/files/user_error.h"

namespace selfproj::files {
namespace fs = std::filesystem;
namespace {

// Attributes that would be lost, such as access control lists. Attributes of the system's own security stay with the
// path.
bool has_attributes(const fs::path& path) {
  std::array<char, 4096> names{};
  const ssize_t bytes = listxattr(path.c_str(), names.data(), names.size());
  if (bytes < 0) {
    return errno == ERANGE;
  }
  for (std::string_view left(names.data(), static_cast<std::size_t>(bytes)); !left.empty();) {
    const std::string_view name = left.substr(0, left.find('\0'));
    if (!name.starts_with("security.")) {
      return true;
    }
    left.remove_prefix(name.size() + 1);
  }
  return false;
}

// The new folder gets rights and owner of the old one.
bool make_like(const fs::path& fresh, const fs::path& old) {
  struct stat want {};
  struct stat have {};
  if (stat(old.c_str(), &want) != 0 || stat(fresh.c_str(), &have) != 0 || has_attributes(old)) {
    return false;
  }
  const bool same_owner = want.st_uid == have.st_uid && want.st_gid == have.st_gid;
  constexpr mode_t kRights = 07777;
  return (same_owner || chown(fresh.c_str(), want.st_uid, want.st_gid) == 0) &&
         chmod(fresh.c_str(), want.st_mode & kRights) == 0;
}

// Links all files of `from` that `to` lacks, including those of inner folders.
bool link_rest(const fs::path& from, const fs::path& to) {  // NOLINT(misc-no-recursion)
  std::error_code error;
  for (fs::directory_iterator at(from, error), end; !error && at != end; at.increment(error)) {
    const fs::path name = at->path().filename();
    const fs::file_status there = fs::symlink_status(to / name, error);
    const bool folder = fs::is_directory(at->symlink_status(error));
    if (fs::exists(there)) {
      if (folder) {
        return false;  // a file in place of a folder
      }
      continue;
    }
    error.clear();
    if (is_temporary_name(name.string())) {
      continue;  // another program removed it; the rest is moved after the exchange
    }
    if (folder) {
      if (mkdir((to / name).c_str(), 0700) != 0 || !link_rest(at->path(), to / name) ||
          !make_like(to / name, at->path())) {
        return false;
      }
    } else if (linkat(AT_FDCWD, at->path().c_str(), AT_FDCWD, (to / name).c_str(), 0) != 0) {
      return false;
    }
  }
  return !error;
}

// Files that another program has put into the old folder since its files were linked.
void move_late_ones(const fs::path& old, const fs::path& fresh) {
  std::error_code error;
  for (fs::directory_iterator at(old, error), end; !error && at != end; at.increment(error)) {
    std::error_code ignored;
    if (!fs::exists(fs::symlink_status(fresh / at->path().filename(), ignored))) {
      fs::rename(at->path(), fresh / at->path().filename(), ignored);
    }
  }
}

// Flushes a file to the disk, so that a loss of power does not lose it.
bool synchronize(const fs::path& path) {
  FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  return file.number() >= 0 && fsync(file.number()) == 0 && file.close();
}

// Replaces `target` by the file `fresh`; an existing `target` becomes `old`. If this fails, `target` stays as it was,
// and `error` has the reason.
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

bool is_exchangeable(const fs::path& folder) {
  std::error_code error;
  const fs::path current = fs::current_path(error);
  const fs::path within = error ? fs::path("..") : current.lexically_relative(folder);
  if (within.empty() || *within.begin() != "..") {
    return false;
  }
  struct stat here {};
  struct stat above {};
  const fs::path parent = parent_of(folder);
  return stat(folder.c_str(), &here) == 0 && stat(parent.c_str(), &above) == 0 && here.st_dev == above.st_dev &&
         here.st_ino != above.st_ino && access(parent.c_str(), W_OK | X_OK) == 0 &&
         access(folder.c_str(), R_OK | W_OK | X_OK) == 0;
}

bool exchange_folders(const fs::path& fresh, const fs::path& target) {
  if (!link_rest(target, fresh) || !make_like(fresh, target) ||
      syscall(SYS_renameat2, AT_FDCWD, fresh.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) != 0) {
    return false;
  }
  move_late_ones(fresh, target);
  return true;
}

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
    throw UserError(name_, "exists and is not a folder");
  }
  exists_ = fs::is_directory(status);
  resolved_ = fs::weakly_canonical(fs::absolute(target_, error), error);
  if (!exists_) {
    if (status.type() != fs::file_type::not_found) {
      throw UserError(name_, error.message());
    }
    static_cast<void>(writable_parent(name_, target_));
    note_output(name_, target_);  // no output may be a file of that name
    return;
  }
  target_ = fs::canonical(target_, error);
  resolved_ = target_;
  if (error || access(target_.c_str(), W_OK | X_OK) != 0) {
    throw UserError(name_, error ? error.message() : error_text(errno));
  }
  beside_ = is_exchangeable(target_);
}

OutputFolder::~OutputFolder() = default;

void OutputFolder::create_staging() {
  // On the file system of the target, so that moving is renaming.
  staging_ = std::make_unique<Temporary>(name_, exists_ && !beside_ ? target_ : writable_parent(name_, target_),
                                         Temporary::Kind::folder);
}

void OutputFolder::check(const std::string& file) const {
  if (exists_ && fs::path(file).has_parent_path()) {
    throw UserError(name_, "exists already; a new folder is needed for results in folders");
  }
  check_output_folder(name_, target_);
  check_output(target_ / file, resolved_ / file);
}

void OutputFolder::append(const std::string& file, std::string_view text) {
  const bool first = std::find(files_.begin(), files_.end(), file) == files_.end();
  if (first) {
    check(file);
  }
  if (staging_ == nullptr) {
    create_staging();
  }
  if (const fs::path inner = fs::path(file).parent_path(); !inner.empty()) {
    std::error_code error;
    fs::create_directories(staging_->path() / inner, error);  // if this fails, opening the file fails too
  }
  FileDescriptor output(open((staging_->path() / file).c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (output.number() < 0 || !write_all(output.number(), text) || !output.close()) {
    throw UserError(target_ / file, error_text(errno));
  }
  if (first) {
    files_.push_back(file);
  }
}

// Throws UserError if the folder holds numbered files of a series of this run that the run has not written.
void OutputFolder::check_series() const {
  // The name without its number; empty if it has none.
  const auto series_of = [](const std::string& file) {
    const fs::path path(file);
    const std::string stem = path.stem().string();
    const std::size_t end = stem.find_last_not_of("0123456789") + 1;
    return stem.size() - end < 2 ? std::string() : stem.substr(0, end) + path.extension().string();
  };
  std::set<std::string> series;
  for (const std::string& file : files_) {
    series.insert(series_of(file));
  }
  series.erase("");
  const std::set<std::string> written(files_.begin(), files_.end());
  std::string other;
  std::error_code error;
  for (fs::directory_iterator at(target_, error), end; !error && at != end; at.increment(error)) {
    const std::string file = at->path().filename().string();
    if (written.count(file) == 0 && series.count(series_of(file)) != 0 && (other.empty() || file < other)) {
      other = file;
    }
  }
  if (!other.empty()) {
    throw UserError(name_, "holds numbered files of another run, such as " + other + "; give another folder");
  }
}

void OutputFolder::commit() {
  if (staging_ == nullptr) {
    create_staging();
  }
  check_series();
  for (const std::string& file : files_) {
    check(file);  // inputs that were read since
    if (!synchronize(staging_->path() / file)) {
      throw UserError(target_ / file, error_text(errno));
    }
  }
  {
    const fs::path above = writable_parent(name_, target_);
    const FolderLock lock(beside_ ? above : target_);
    const SignalsHeld held;
    std::error_code error;
    exists_ = fs::is_directory(target_, error);  // another program may have made or removed it
    if (!exists_) {
      move_in_new();
    } else if (!beside_ || !exchange()) {
      move_in_each();
    }
    lock.synchronize();
  }
  staging_.reset();
}

void OutputFolder::move_in_new() {
  std::error_code error;
  MadeFolders parents(parent_of(target_), error);
  if (!error && rename(staging_->path().c_str(), target_.c_str()) != 0) {
    error = std::error_code(errno, std::generic_category());
  }
  if (error) {
    throw UserError(name_, error.message());
  }
  staging_->keep();
  parents.keep();
}

// Returns false if it cannot be done in one step.
bool OutputFolder::exchange() {
  for (const std::string& file : files_) {
    std::error_code error;
    if (fs::is_directory(fs::symlink_status(target_ / file, error))) {
      throw UserError(target_ / file, error_text(EISDIR));
    }
  }
  return exchange_folders(staging_->path(), target_);
}

// Moves file by file, and keeps each old file until the last new one is in place.
void OutputFolder::move_in_each() {
  const fs::path& staging = staging_->path();
  std::error_code error;
  std::size_t done = 0;
  while (done < files_.size() &&
         replace(target_ / files_[done], staging / files_[done], staging / (".old-" + files_[done]), error)) {
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
    fs::rename(staging / (".old-" + files_[done]), target_ / files_[done], ignored);
  }
  throw UserError(failed, error.message());
}

}  // namespace selfproj::files
