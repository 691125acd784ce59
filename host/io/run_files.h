// What a run of a program reads and what it writes.
#ifndef SELFPROJ_HOST_IO_RUN_FILES_H
#define SELFPROJ_HOST_IO_RUN_FILES_H

#include <filesystem>
#include <string>

namespace selfproj {

// While it lives, no output may be one of the inputs, and no two outputs one file: the same file (by device and inode)
// or the same name. Every reader and every writer of host/io and host/driver says what it does, so that no command has
// to. Only files count, no pipes and devices. One at a time; without one (in tests of parts) nothing is watched.
class RunFiles {
 public:
  RunFiles();
  RunFiles(const RunFiles&) = delete;
  RunFiles& operator=(const RunFiles&) = delete;
  ~RunFiles();
};

// This run reads `file`. Throws UserError naming an output that it is.
void note_input(const std::string& file);

// This run will write the file `target`, which the user calls `name`. Throws UserError, naming it, where it is an input
// or another output.
void note_output(const std::string& name, const std::filesystem::path& target);

// The same without a note, for files of a folder. The folder's name should have no links.
void check_output(const std::string& name, const std::filesystem::path& target);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_RUN_FILES_H
