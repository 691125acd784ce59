#include "host/files/folder_exchange.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "host/files/output_parents.h"
#include "host/files/temporary.h"

namespace selfproj {
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

}  // namespace selfproj
