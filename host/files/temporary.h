// Files and folders that exist only while a program runs, unless they are kept.
#ifndef SELFPROJ_HOST_FILES_TEMPORARY_H
#define SELFPROJ_HOST_FILES_TEMPORARY_H

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "host/files/file_descriptor.h"

namespace selfproj::files {

// While it lives, other programs of this project cannot make, remove or exchange files in a folder (flock on the
// folder; no lock file is needed). Waits up to ten seconds for the others. If the file system has no such lock, or the
// others keep it longer, the program continues without it.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock() = default;

  [[nodiscard]] bool held() const { return held_; }
  // Flushes renames in the folder to the disk.
  void synchronize() const;

 private:
  FileDescriptor folder_;
  bool held_ = false;
};

// A file or folder that is removed with its contents at the end of this object, or when a signal ends the program
// (tidy_up_on_signals), if it exists. It need not be made by this program.
class RemovedAtEnd {
 public:
  explicit RemovedAtEnd(const std::filesystem::path& path) { remove_at_end(path); }
  RemovedAtEnd(const RemovedAtEnd&) = delete;
  RemovedAtEnd& operator=(const RemovedAtEnd&) = delete;
  ~RemovedAtEnd();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  // Call when it has its final name: it then stays.
  void keep();

 protected:
  RemovedAtEnd() = default;
  void remove_at_end(const std::filesystem::path& path);

 private:
  std::filesystem::path path_;
  std::size_t place_ = 0;  // index in the list of paths to remove
};

// A new locked file or folder `.selfproj-PID-N.tmp`. The next Temporary in the same folder removes files left by
// SIGKILL or a loss of power.
class Temporary : public RemovedAtEnd {
 public:
  enum class Kind : std::uint8_t { file, folder };

  // Throws UserError about `name`, which the user gave.
  Temporary(const std::string& name, const std::filesystem::path& in, Kind kind);

  // The descriptor of the file, for writing, or of the folder.
  [[nodiscard]] FileDescriptor& descriptor() { return descriptor_; }

 private:
  FileDescriptor descriptor_{-1};
};

// Whether the name has the form of Temporary's names.
bool is_temporary_name(const std::string& name);

// For signal handlers: removes all of them.
void remove_temporaries();

// The folder that holds the file: "." if the name has none.
std::filesystem::path parent_of(const std::filesystem::path& path);

// The nearest existing folder above `target`. Throws UserError about `name`, which the user gave, if nothing can be
// made in it.
std::filesystem::path writable_parent(const std::string& name, const std::filesystem::path& target);

// Makes a folder and its missing parents, and removes them again unless they are kept.
class MadeFolders {
 public:
  MadeFolders(const std::filesystem::path& folder, std::error_code& error);
  MadeFolders(const MadeFolders&) = delete;
  MadeFolders& operator=(const MadeFolders&) = delete;
  ~MadeFolders();

  void keep() { made_.clear(); }

 private:
  std::vector<std::filesystem::path> made_;  // from the top down
};

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_TEMPORARY_H
