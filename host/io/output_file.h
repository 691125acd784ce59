#ifndef SELFPROJ_HOST_IO_OUTPUT_FILE_H
#define SELFPROJ_HOST_IO_OUTPUT_FILE_H

#include <filesystem>
#include <string>
#include <string_view>

namespace selfproj {

// A file that is written whole or not at all: it appears (or is replaced) in one step once everything is on disk, and
// whatever fails or ends the program before leaves an existing file as it was, and nothing beside it. A link is
// followed; a device or pipe is written to directly. Folders above it that are missing are made with it. It may be no
// input and no other output of the run (run_files.h).
class OutputFile {
 public:
  // Checks, touching nothing, that the file could be written, so that a long run does not end in a wrong name.
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
