// Runs a program in a new empty folder.
#ifndef SELFPROJ_TESTS_CLI_PROGRAM_H
#define SELFPROJ_TESTS_CLI_PROGRAM_H

#include <filesystem>
#include <string>
#include <vector>

namespace selfproj::test {

// An empty folder that is removed with its contents at the end.
class ScratchFolder {
 public:
  ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  // The names of its entries, in order.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

struct Outcome {
  int status = -1;  // exit status, or 128 + number of the signal that ended it
  std::string out;
  std::string err;
};

// Runs the program with these arguments in `folder`. Its output is kept outside of the folder.
Outcome run_program(const std::string& program, const std::vector<std::string>& arguments,
                    const std::filesystem::path& folder);

std::string read_text(const std::filesystem::path& file);
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_CLI_PROGRAM_H
