#ifndef SELFPROJ_HOST_IO_OUTPUT_FOLDER_H
#define SELFPROJ_HOST_IO_OUTPUT_FOLDER_H

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace selfproj {

// A folder of results that is written whole or not at all. The files are written into a temporary folder, and `commit`
// moves them to their place once all are on disk; whatever fails before, or in the moving, leaves what was there as it
// was, and so does going without a commit. Where the folder is there already, its other files stay.
class OutputFolder {
 public:
  // Checks, touching nothing, that the folder could be made or written to, so that a long run does not end in a wrong
  // name. Throws UserError.
  explicit OutputFolder(const std::string& name);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  // Adds text at the end of the file `file`, which the first call creates: a name without a path, or, where the folder
  // is not there yet, one in a folder within, `inner/name`. Throws UserError.
  void append(const std::string& file, std::string_view text);

  // Moves the files to where they belong; nothing can be added after that. Throws UserError.
  void commit();

  // As given by the user.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  void create_staging();
  void move_in();

  std::string name_;
  std::filesystem::path target_;
  bool exists_ = false;             // the target, as a folder
  std::filesystem::path staging_;   // empty before the first file and after the commit
  std::vector<std::string> files_;  // those written, in order
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_OUTPUT_FOLDER_H
