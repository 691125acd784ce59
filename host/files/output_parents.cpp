#include "host/files/output_parents.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "host/files/file_descriptor.h"
#include "host/files/user_error.h"

namespace selfproj {
namespace fs = std::filesystem;

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

}  // namespace selfproj
