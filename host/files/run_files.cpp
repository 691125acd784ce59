#include "host/files/run_files.h"

#include <sys/stat.h>

#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "selfproj/files/user_error.h"

namespace selfproj::files {
namespace fs = std::filesystem;
namespace {

using FileId = std::pair<dev_t, ino_t>;

// The known files of the run.
struct Notes {
  std::mutex mutex;
  bool watching = false;
  std::set<FileId> inputs;
  std::set<std::string> input_paths;
  std::set<FileId> input_folders;
  std::map<std::string, std::string> outputs;  // their paths, and the names that the user gave
};

Notes& notes() {
  static Notes notes;
  return notes;
}

// The path without links, "." and "..". If the file does not exist, those of its folder are resolved.
std::string path_of(const fs::path& file) {
  std::error_code error;
  const fs::path absolute = fs::absolute(file, error);  // of a path of which nothing exists, the next keeps it relative
  const fs::path path = fs::weakly_canonical(absolute, error);
  return error ? absolute.lexically_normal().string() : path.string();
}

[[noreturn]] void fail(const std::string& output) {
  throw UserError(output, "is an input of this command, too; it would be overwritten");
}

// Whether it cannot be overwritten, because it is a pipe, device or folder.
bool passes(const struct stat& status) { return !S_ISREG(status.st_mode); }

void check(const Notes& notes, const std::string& name, const fs::path& target, const std::string& path) {
  struct stat status {};
  const bool there = stat(target.c_str(), &status) == 0;
  if (there && passes(status)) {
    return;
  }
  if (notes.input_paths.contains(path) || (there && notes.inputs.contains({status.st_dev, status.st_ino}))) {
    fail(name);
  }
}

}  // namespace

RunFiles::RunFiles() { notes().watching = true; }

RunFiles::~RunFiles() {
  Notes& all = notes();
  all.watching = false;
  all.inputs.clear();
  all.input_paths.clear();
  all.input_folders.clear();
  all.outputs.clear();
}

void note_input(const std::string& file) {
  Notes& all = notes();
  const std::lock_guard lock(all.mutex);
  struct stat status {};
  if (!all.watching || stat(file.c_str(), &status) != 0 || passes(status)) {
    return;
  }
  const FileId id{status.st_dev, status.st_ino};
  const std::string path = path_of(file);
  all.inputs.insert(id);
  all.input_paths.insert(path);
  for (const auto& [output, name] : all.outputs) {
    struct stat other {};
    if (output == path || (stat(output.c_str(), &other) == 0 && FileId{other.st_dev, other.st_ino} == id)) {
      fail(name);
    }
  }
}

void note_input_folder(const std::string& folder) {
  Notes& all = notes();
  const std::lock_guard lock(all.mutex);
  struct stat status {};
  if (all.watching && stat(folder.c_str(), &status) == 0) {
    all.input_folders.insert({status.st_dev, status.st_ino});
  }
}

void check_output_folder(const std::string& name, const fs::path& target) {
  Notes& all = notes();
  const std::lock_guard lock(all.mutex);
  struct stat status {};
  if (stat(target.c_str(), &status) == 0 && all.input_folders.contains({status.st_dev, status.st_ino})) {
    throw UserError(name, "is the folder whose files are read; results in it would be read the next time");
  }
}

void note_output(const std::string& name, const fs::path& target) {
  Notes& all = notes();
  const std::lock_guard lock(all.mutex);
  if (!all.watching) {
    return;
  }
  const std::string path = path_of(target);
  check(all, name, target, path);
  struct stat status {};
  const bool there = stat(target.c_str(), &status) == 0;
  if (there && passes(status)) {
    return;
  }
  for (const auto& [output, other_name] : all.outputs) {
    struct stat other {};
    if (output == path || (there && stat(output.c_str(), &other) == 0 && other.st_dev == status.st_dev &&
                           other.st_ino == status.st_ino)) {
      throw UserError(name, "is already an output of this command, " + other_name);
    }
  }
  all.outputs.emplace(path, name);
}

void check_output(const std::string& name, const fs::path& target) {
  Notes& all = notes();
  const std::lock_guard lock(all.mutex);
  if (!all.watching) {
    return;
  }
  std::error_code error;
  const std::string path = fs::absolute(target, error).lexically_normal().string();  // a folder may have many files
  check(all, name, target, path);
  if (const auto found = all.outputs.find(path); found != all.outputs.end()) {
    throw UserError(name, "is already an output of this command, " + found->second);
  }
}

}  // namespace selfproj::files
