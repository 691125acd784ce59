// The inputs and outputs of a run of a program.
#ifndef SELFPROJ_HOST_FILES_RUN_FILES_H
#define SELFPROJ_HOST_FILES_RUN_FILES_H

#include <filesystem>
#include <string>

namespace selfproj::files {

// While this object lives, no output may be an input, and no two outputs may be one file: the same file (by device and
// inode) or the same name. Every reader and writer of host/files, host/images and host/driver reports its files here,
// so that commands need not. Pipes and devices do not count. Only one such object can exist; without one (in tests of
// parts) nothing is checked.
class RunFiles {
 public:
  RunFiles();
  RunFiles(const RunFiles&) = delete;
  RunFiles& operator=(const RunFiles&) = delete;
  ~RunFiles();
};

// Notes that this run reads `file`. Throws UserError, naming the output, if it is one.
void note_input(const std::string& file);

// Notes that this run reads what a folder holds. Nothing may be written into it, as it would be read the next time.
void note_input_folder(const std::string& folder);

// Throws UserError, naming it as the user does, if the folder `target` is one that this run reads whole.
void check_output_folder(const std::string& name, const std::filesystem::path& target);

// Notes that this run will write the file `target`, which the user calls `name`. Throws UserError, naming it, if it is
// an input or another output.
void note_output(const std::string& name, const std::filesystem::path& target);

// The same check without a note, for files of a folder. The folder's name should have no links.
void check_output(const std::string& name, const std::filesystem::path& target);

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_RUN_FILES_H
