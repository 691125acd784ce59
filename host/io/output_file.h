#ifndef SELFPROJ_HOST_IO_OUTPUT_FILE_H
#define SELFPROJ_HOST_IO_OUTPUT_FILE_H

#include <filesystem>
#include <string>
#include <string_view>

namespace selfproj {

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
  std::string name_;
  std::filesystem::path target_;
  std::filesystem::file_status status_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_OUTPUT_FILE_H
