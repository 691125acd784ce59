// A display for tests: Xvfb, whose frame buffer is a file that is read directly, without a word to the server.
#ifndef SELFPROJ_TESTS_SUPPORT_VIRTUAL_SCREEN_H
#define SELFPROJ_TESTS_SUPPORT_VIRTUAL_SCREEN_H

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

extern char** environ;  // NOLINT(readability-redundant-declaration)

namespace selfproj::test {

class VirtualScreen {
 public:
  static bool installed() { return std::filesystem::exists("/usr/bin/Xvfb"); }

  // Starts a display of this size, with its frame buffer in `folder`, and makes it the DISPLAY of this process and its
  // children.
  VirtualScreen(int columns, int rows, const std::filesystem::path& folder) : columns_(columns), rows_(rows) {
    std::array<int, 2> answer{};
    if (pipe(answer.data()) != 0) {
      throw std::runtime_error("no pipe");
    }
    const std::string size = std::to_string(columns) + "x" + std::to_string(rows) + "x24";
    const std::string number_to = std::to_string(answer[1]);
    std::vector<std::string> words = {"Xvfb",   "-displayfd", number_to,   "-screen", "0",        size,
                                      "-fbdir", folder,       "-nolisten", "tcp",     "-noreset", "-nocursor"};
    std::vector<char*> arguments;
    for (std::string& word : words) {
      arguments.push_back(word.data());
    }
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    const int error = posix_spawn(&process_, "/usr/bin/Xvfb", &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(answer[1]);
    std::string number;
    for (char one = 0; error == 0 && read(answer[0], &one, 1) == 1 && one != '\n';) {
      number += one;
    }
    close(answer[0]);
    if (number.empty()) {
      throw std::runtime_error("Xvfb does not start");
    }
    setenv("DISPLAY", (":" + number).c_str(), 1);
    map(folder / "Xvfb_screen0");
  }
  VirtualScreen(const VirtualScreen&) = delete;
  VirtualScreen& operator=(const VirtualScreen&) = delete;

  ~VirtualScreen() {
    end();
    munmap(const_cast<std::uint8_t*>(bytes_), size_);
  }

  // Unplugs the display.
  void end() {
    if (process_ > 0) {
      kill(process_, SIGTERM);
      waitpid(process_, nullptr, 0);
      process_ = 0;
    }
  }

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }

  // A copy of what is shown: the red values; `grey` tells whether every pixel is grey.
  std::vector<std::uint8_t> picture(bool* grey = nullptr) const {
    std::vector<std::uint8_t> out(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    bool all_grey = true;
    std::size_t at = 0;
    for (int row = 0; row < rows_; ++row) {
      const std::uint8_t* pixel = bytes_ + first_ + static_cast<std::size_t>(row) * line_;
      for (int column = 0; column < columns_; ++column, pixel += 4) {
        out[at++] = pixel[2];
        all_grey = all_grey && pixel[0] == pixel[2] && pixel[1] == pixel[2];
      }
    }
    if (grey != nullptr) {
      *grey = all_grey;
    }
    return out;
  }

 private:
  // The file is a picture of X's format xwd: a header of big-endian words, colours, pixels.
  void map(const std::filesystem::path& file) {
    const int descriptor = open(file.c_str(), O_RDONLY);
    struct stat status {};
    if (descriptor < 0 || fstat(descriptor, &status) != 0) {
      throw std::runtime_error("no frame buffer");
    }
    size_ = static_cast<std::size_t>(status.st_size);
    bytes_ = static_cast<const std::uint8_t*>(mmap(nullptr, size_, PROT_READ, MAP_SHARED, descriptor, 0));
    close(descriptor);
    const auto word = [&](std::size_t index) {
      const std::uint8_t* const at = bytes_ + 4 * index;
      return std::size_t{at[0]} << 24U | std::size_t{at[1]} << 16U | std::size_t{at[2]} << 8U | at[3];
    };
    constexpr std::size_t kColourBytes = 12;
    first_ = word(0) + word(19) * kColourBytes;
    line_ = word(12);
    if (word(4) != static_cast<std::size_t>(columns_) || word(5) != static_cast<std::size_t>(rows_) || word(11) != 32) {
      throw std::runtime_error("the frame buffer has another size");
    }
  }

  int columns_;
  int rows_;
  pid_t process_ = 0;
  const std::uint8_t* bytes_ = nullptr;
  std::size_t size_ = 0;
  std::size_t first_ = 0;
  std::size_t line_ = 0;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_VIRTUAL_SCREEN_H
