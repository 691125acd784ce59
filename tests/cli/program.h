// Runs a program in an empty folder of its own.
#ifndef SELFPROJ_TESTS_CLI_PROGRAM_H
#define SELFPROJ_TESTS_CLI_PROGRAM_H

#include <filesystem>
#include <string>
#include <vector>

namespace selfproj::test {

// An empty folder that goes away, with all it contains, at the end.
class ScratchFolder {
 public:
  ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  // The names of what is in it, in order.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

struct Outcome {
  int status = -1;  // exit status; 128 + number where a signal ended it
  std::string out;
  std::string err;
};

// Runs the program with these arguments in `folder`; what it prints is kept outside of it.
Outcome run_program(const std::string& program, const std::vector<std::string>& arguments,
                    const std::filesystem::path& folder);

std::string read_text(const std::filesystem::path& file);
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_CLI_PROGRAM_H
