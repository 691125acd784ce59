// Files and folders that are there only while a program runs.
#ifndef SELFPROJ_HOST_IO_TEMPORARY_H
#define SELFPROJ_HOST_IO_TEMPORARY_H

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "host/io/file_descriptor.h"

namespace selfproj {

// Keeps other programs of this project from making, sweeping and exchanging things in a folder while it lives (flock on
// the folder; no file is needed). Waits ten seconds for the others; where the file system knows no such lock, or they
// keep it longer, it goes on without.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock() = default;

  [[nodiscard]] bool held() const { return held_; }
  // Takes what was renamed in the folder to the disk.
  void synchronize() const;

 private:
  FileDescriptor folder_;
  bool held_ = false;
};

// A new file or folder `.selfproj-PID-N.tmp`, locked. It goes away with this object, with all it holds, and where a
// signal ends the program (tidy_up_on_signals); what SIGKILL or a loss of power leaves behind, the next Temporary in
// the same folder takes away.
class Temporary {
 public:
  enum class Kind : std::uint8_t { file, folder };

  // Throws std::system_error.
  Temporary(const std::filesystem::path& in, Kind kind);
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // Of the file, for writing, or of the folder.
  [[nodiscard]] FileDescriptor& descriptor() { return descriptor_; }

  // It has got the name that it was made for, and stays.
  void keep();

 private:
  std::filesystem::path path_;
  FileDescriptor descriptor_;
  std::size_t place_;  // in the list of those that are to be removed
};

// A file or folder of another name that goes away like a Temporary, if it is there. What it is need not be ours.
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

// Whether a name is one that Temporary makes.
bool is_temporary_name(const std::string& name);

// For signal handlers: takes all of them away.
void remove_temporaries();

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_TEMPORARY_H
