// Files and folders that exist only while a program runs.
#ifndef SELFPROJ_HOST_FILES_TEMPORARY_H
#define SELFPROJ_HOST_FILES_TEMPORARY_H

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "host/files/file_descriptor.h"

namespace selfproj {

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

// A new locked file or folder `.selfproj-PID-N.tmp`. It is removed with its contents at the end of this object, or when
// a signal ends the program (tidy_up_on_signals). The next Temporary in the same folder removes files left by SIGKILL
// or a loss of power.
class Temporary {
 public:
  enum class Kind : std::uint8_t { file, folder };

  // Throws std::system_error.
  Temporary(const std::filesystem::path& in, Kind kind);
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // The descriptor of the file, for writing, or of the folder.
  [[nodiscard]] FileDescriptor& descriptor() { return descriptor_; }

  // Call when it has its final name: it then stays.
  void keep();

 private:
  std::filesystem::path path_;
  FileDescriptor descriptor_;
  std::size_t place_;  // index in the list of paths to remove
};

// A file or folder of another name that is removed like a Temporary if it exists. It need not be made by this program.
class RemovedAtEnd {
 public:
  explicit RemovedAtEnd(const std::filesystem::path& path);
  RemovedAtEnd(const RemovedAtEnd&) = delete;
  RemovedAtEnd& operator=(const RemovedAtEnd&) = delete;
  ~RemovedAtEnd();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  void keep();

 private:
  std::filesystem::path path_;
  std::size_t place_;
};

// Whether the name has the form of Temporary's names.
bool is_temporary_name(const std::string& name);

// For signal handlers: removes all of them.
void remove_temporaries();

}  // namespace selfproj

#endif  // SELFPROJ_HOST_FILES_TEMPORARY_H
