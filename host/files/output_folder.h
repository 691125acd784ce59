#ifndef SELFPROJ_HOST_FILES_OUTPUT_FOLDER_H
#define SELFPROJ_HOST_FILES_OUTPUT_FOLDER_H

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/files/temporary.h"

namespace selfproj::files {

// A folder of results that is written whole or not at all. The files are written into a temporary folder beside it, and
// `commit` exchanges the two in one step once everything is on disk. If anything fails or ends the program before, or
// without a commit, the old folder stays as it was. If several programs write into one folder, their results appear
// whole, one after another. Other files of an existing folder stay; missing parent folders are made.
//
// If the exchange is not possible, the files are renamed one after another instead. This is so if the folder is a mount
// point, the current folder or one above it, if its parent folder cannot be written to, or if the file system lacks
// exchange or hard links. Then only SIGKILL or a loss of power between these renames leaves old and new files mixed.
//
// Numbered files (NAME_00.EXT, two digits or more) are a series, which is read as a whole: a folder that has files of
// the same series beyond those of this run is refused.
//
// No file of it may be an input of the run (run_files.h).
class OutputFolder {
 public:
  // Checks that the folder could be made or written to, without changing anything, so that a wrong name is found before
  // a long run. Throws UserError.
  explicit OutputFolder(const std::string& name);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  // Finds an error early that `append` would find late: throws UserError if `file` may not be written.
  void check(const std::string& file) const;

  // Appends text to the file `file`, which the first call creates. `file` is a name without a path or, if the folder
  // does not exist yet, `inner/name`. Throws UserError.
  void append(const std::string& file, std::string_view text);

  // Moves the files to their place. Nothing can be added afterwards. Throws UserError.
  void commit();

  // As given by the user.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  void create_staging();
  void check_series() const;
  void move_in_new();
  [[nodiscard]] bool exchange();
  void move_in_each();

  std::string name_;
  std::filesystem::path target_;
  std::filesystem::path resolved_;      // the same without links, also if it does not exist yet
  bool exists_ = false;                 // the target, as a folder
  bool beside_ = true;                  // the temporary folder is not in the target
  std::unique_ptr<Temporary> staging_;  // from the first file to the commit
  std::vector<std::string> files_;      // files written, in order
};

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_OUTPUT_FOLDER_H
