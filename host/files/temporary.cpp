#include "host/files/temporary.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "host/files/file_descriptor.h"
#include "host/files/signals_held.h"
#include "selfproj/files/user_error.h"

namespace selfproj::files {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kPrefix = ".selfproj-";
constexpr std::string_view kSuffix = ".tmp";

// Paths to remove; the signal handler reads them. A command has few outputs, and each needs two paths.
constexpr std::size_t kPlaces = 256;
std::array<std::atomic<const char*>, kPlaces> places{};  // NOLINT: a signal handler needs it

// An entry as getdents64 returns it.
struct Entry {
  std::uint64_t inode;
  std::int64_t offset;
  std::uint16_t bytes;
  std::uint8_t type;
  char name[1];  // NOLINT(modernize-avoid-c-arrays): the kernel's
};

void remove_tree(int at, const char* name, int depth);

// Removes the contents of the folder; calls only the kernel. Returns false if there is nothing.
bool empty_folder(int folder, int depth) {
  alignas(Entry) std::array<char, 4096> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  bool found = false;
  lseek(folder, 0, SEEK_SET);
  for (;;) {
    const long bytes = syscall(SYS_getdents64, folder, buffer.data(), buffer.size());
    if (bytes <= 0) {
      return found;
    }
    for (long at = 0; at < bytes;) {
      const auto* entry = reinterpret_cast<const Entry*>(buffer.data() + at);
      const char* name = static_cast<const char*>(entry->name);
      at += entry->bytes;
      if (std::strcmp(name, ".") != 0 && std::strcmp(name, "..") != 0) {
        found = true;
        remove_tree(folder, name, depth - 1);
      }
    }
  }
}

// Makes only calls that are allowed in a signal handler.
void remove_tree(int at, const char* name, int depth) {  // NOLINT(misc-no-recursion)
  if (unlinkat(at, name, 0) == 0 || depth == 0) {
    return;
  }
  const int folder = openat(at, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0) {
    return;
  }
  constexpr int kPasses = 100;  // another thread may add files meanwhile
  for (int pass = 0; pass < kPasses; ++pass) {
    const bool found = empty_folder(folder, depth);
    if (unlinkat(at, name, AT_REMOVEDIR) == 0 || !found) {
      break;
    }
  }
  close(folder);
}

constexpr int kDepth = 64;

void remove_path(const char* path) { remove_tree(AT_FDCWD, path, kDepth); }

std::size_t claim_place(const fs::path& path) {
  // The text lives as long as the program, because a signal may come at any time. There are few of these texts.
  char* const text = strdup(path.c_str());
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const char* none = nullptr;
    if (places.at(i).compare_exchange_strong(none, text)) {
      return i;
    }
  }
  free(text);  // NOLINT
  return kPlaces;
}

void release_place(std::size_t place) {
  if (place < kPlaces) {
    free(const_cast<char*>(places.at(place).exchange(nullptr)));  // NOLINT
  }
}

// Left by a program that was killed: nobody has it locked.
void remove_abandoned(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (is_temporary_name(at->path().filename().string())) {
      found.push_back(at->path());
    }
  }
  for (const fs::path& path : found) {
    const FileDescriptor there(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    struct stat status {};
    if (there.number() >= 0 && fstat(there.number(), &status) == 0 && status.st_uid == geteuid() &&
        (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) && flock(there.number(), LOCK_EX | LOCK_NB) == 0) {
      remove_path(path.c_str());
    }
  }
}

int make(const fs::path& path, Temporary::Kind kind) {
  if (kind == Temporary::Kind::file) {
    return open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);  // less the user's umask
  }
  if (mkdir(path.c_str(), 0777) != 0) {
    return -1;
  }
  return open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

int make_first_free(const fs::path& in, Temporary::Kind kind, fs::path& path) {
  constexpr int kTries = 1000;
  int descriptor = -1;
  for (int i = 0; i < kTries && descriptor < 0; ++i) {
    path = in / (std::string(kPrefix) + std::to_string(getpid()) + "-" + std::to_string(i) + std::string(kSuffix));
    descriptor = make(path, kind);
    if (descriptor < 0 && errno != EEXIST) {
      break;
    }
  }
  return descriptor;
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) : folder_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  constexpr int kTries = 2000;
  constexpr timespec kPause{0, 5'000'000};
  for (int i = 0; i < kTries && !held_ && folder_.number() >= 0; ++i) {
    held_ = flock(folder_.number(), LOCK_EX | LOCK_NB) == 0;
    if (!held_ && errno != EWOULDBLOCK && errno != EINTR) {
      return;
    }
    if (!held_) {
      nanosleep(&kPause, nullptr);
    }
  }
}

void FolderLock::synchronize() const {
  if (folder_.number() >= 0) {
    static_cast<void>(fsync(folder_.number()));
  }
}

RemovedAtEnd::~RemovedAtEnd() {
  if (!path_.empty()) {
    remove_path(path_.c_str());
    release_place(place_);
  }
}

void RemovedAtEnd::keep() {
  release_place(place_);
  path_.clear();
}

void RemovedAtEnd::remove_at_end(const fs::path& path) {
  path_ = path;
  place_ = claim_place(path);
}

Temporary::Temporary(const std::string& name, const fs::path& in, Kind kind) {
  const FolderLock lock(in);
  if (lock.held()) {
    remove_abandoned(in);
  }
  const SignalsHeld held;
  fs::path path;
  descriptor_.reset(make_first_free(in, kind, path));
  if (descriptor_.number() < 0) {
    throw UserError(name, error_text(errno));
  }
  static_cast<void>(flock(descriptor_.number(), LOCK_EX | LOCK_NB));
  std::error_code error;
  const fs::path whole = fs::absolute(path, error);
  remove_at_end(error ? path : whole);
}

bool is_temporary_name(const std::string& name) {
  if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix) || name.size() <= kPrefix.size() + kSuffix.size()) {
    return false;
  }
  const std::string middle = name.substr(kPrefix.size(), name.size() - kPrefix.size() - kSuffix.size());
  return std::count(middle.begin(), middle.end(), '-') == 1 && middle.front() != '-' && middle.back() != '-' &&
         std::all_of(middle.begin(), middle.end(),
                     [](char c) { return c == '-' || std::isdigit(static_cast<unsigned char>(c)) != 0; });
}

void remove_temporaries() {
  for (std::atomic<const char*>& place : places) {
    if (const char* path = place.load()) {
      remove_path(path);
    }
  }
}

fs::path parent_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

fs::path writable_parent(const std::string& name, const fs::path& target) {
  std::error_code error;
  fs::path parent = parent_of(target);
  fs::file_status status = fs::status(parent, error);
  while (status.type() == fs::file_type::not_found && parent.has_parent_path() && parent.parent_path() != parent) {
    parent = parent.parent_path();
    status = fs::status(parent, error);
  }
  if (status.type() == fs::file_type::not_found) {  // a name such as "a/b": a is not there
    parent = ".";
    status = fs::status(parent, error);
  }
  if (!fs::exists(status)) {
    throw UserError(name, parent.string() + ": " + error.message());
  }
  if (!fs::is_directory(status)) {
    throw UserError(name, parent.string() + " is not a folder");
  }
  if (access(parent.c_str(), W_OK | X_OK) != 0) {
    throw UserError(name, error_text(errno));
  }
  return parent;
}

MadeFolders::MadeFolders(const fs::path& folder, std::error_code& error) {
  std::vector<fs::path> missing;
  for (fs::path at = folder; !at.empty() && !fs::exists(fs::status(at, error)); at = at.parent_path()) {
    if (at.has_filename()) {
      missing.push_back(at);
    }
    if (at.parent_path() == at) {
      break;
    }
  }
  error.clear();
  for (auto at = missing.rbegin(); at != missing.rend() && !error; ++at) {
    if (mkdir(at->c_str(), 0777) == 0) {  // less the user's umask
      made_.push_back(*at);
    } else if (errno != EEXIST) {
      error = std::error_code(errno, std::generic_category());
    }
  }
}

MadeFolders::~MadeFolders() {
  for (auto at = made_.rbegin(); at != made_.rend(); ++at) {
    rmdir(at->c_str());
  }
}

}  // namespace selfproj::files
