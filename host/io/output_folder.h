#ifndef SELFPROJ_HOST_IO_OUTPUT_FOLDER_H
#define SELFPROJ_HOST_IO_OUTPUT_FOLDER_H

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/temporary.h"

namespace selfproj {

// A folder of results that is written whole or not at all. The files are written into a temporary folder beside it, and
// `commit` exchanges the two in one step once all is on disk: whatever fails or ends the program before leaves what was
// there as it was, and so does going without a commit. Of several programs that write into one folder each is whole,
// one after the other. Where the folder is there already, its other files stay; missing folders above it are made with
// it.
//
// Where the exchange is not possible (the folder is the current one or above it, or a mount point; the folder above
// cannot be written to; the file system has no exchange or no hard links) the files are renamed one after the other
// instead. Then only a kill by SIGKILL or a loss of power within these renames leaves old and new files mixed.
//
// No file may be an input of the run (run_files.h).
class OutputFolder {
 public:
  // Checks, touching nothing, that the folder could be made or written to, so that a long run does not end in a wrong
  // name. Throws UserError.
  explicit OutputFolder(const std::string& name);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  // Says early what `append` would say late: throws UserError where the file `file` may not be written.
  void check(const std::string& file) const;

  // Adds text at the end of the file `file`, which the first call creates: a name without a path, or, where the folder
  // is not there yet, one in a folder within, `inner/name`. Throws UserError.
  void append(const std::string& file, std::string_view text);

  // Moves the files to where they belong; nothing can be added after that. Throws UserError.
  void commit();

  // As given by the user.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  void create_staging();
  void move_in_new();
  [[nodiscard]] bool exchange();
  void move_in_each();

  std::string name_;
  std::filesystem::path target_;
  bool exists_ = false;                 // the target, as a folder
  bool beside_ = true;                  // the temporary folder is not in the target
  std::unique_ptr<Temporary> staging_;  // from the first file to the commit
  std::vector<std::string> files_;      // those written, in order
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_OUTPUT_FOLDER_H
