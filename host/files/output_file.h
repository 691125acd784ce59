#ifndef SELFPROJ_HOST_FILES_OUTPUT_FILE_H
#define SELFPROJ_HOST_FILES_OUTPUT_FILE_H

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "host/files/file_descriptor.h"
#include "host/files/temporary.h"

namespace selfproj::files {

// A file that is written whole or not at all. It appears (or is replaced) in one step once everything is on disk. If
// anything fails or ends the program before, an existing file stays as it was, and no other file is left. A link is
// followed; a device or pipe is written to directly. Missing parent folders are made. The file must not be an input or
// another output of the run (run_files.h).
class OutputFile {
 public:
  // Checks that the file could be written, without changing anything, so that a wrong name is found before a long run.
  // Throws UserError.
  explicit OutputFile(const std::string& name);

  // Throws UserError.
  void write(std::string_view text) const;

  // As given by the user.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  friend class OutputStream;

  std::string name_;
  std::filesystem::path target_;
  std::filesystem::file_status status_;
};

// An output file that is written piece by piece. Nothing appears, or is replaced, before `commit`; without it nothing
// is left. (What goes to a device or pipe is there at once.)
class OutputStream {
 public:
  // `file` must outlive it. Throws UserError.
  explicit OutputStream(const OutputFile& file);
  OutputStream(const OutputStream&) = delete;
  OutputStream& operator=(const OutputStream&) = delete;
  ~OutputStream() = default;

  // Throw UserError.
  void append(std::string_view text);
  void commit();

  // Commits no more than the first `bytes`, after a failure. Throws UserError.
  void commit_first(std::uint64_t bytes);

 private:
  void must(bool done) const;

  const OutputFile& file_;
  std::optional<Temporary> temporary_;  // takes the target's place at the end; empty: a device or pipe
  FileDescriptor device_{-1};
};

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_OUTPUT_FILE_H
