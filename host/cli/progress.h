#ifndef SELFPROJ_HOST_CLI_PROGRESS_H
#define SELFPROJ_HOST_CLI_PROGRESS_H

#include <chrono>
#include <cstddef>
#include <string>

namespace selfproj {

// One line on standard error that counts up, "frame 120 of 1400", and disappears at the end. If the total is 0
// (unknown), it says "frame 120". Only on a terminal.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  // Updates the line at most ten times a second, with the note after the count.
  void update(std::size_t done, const std::string& note = {});

  // Whether the next update will be shown: for notes that take time to write.
  [[nodiscard]] bool due() const;

 private:
  std::string what_;
  std::size_t total_;
  bool shown_ = false;
  bool terminal_;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CLI_PROGRESS_H
