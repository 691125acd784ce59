// Lines on standard error that are rewritten while a program works, and disappear at the end. Only on a terminal.
#ifndef SELFPROJ_HOST_CLI_PROGRESS_H
#define SELFPROJ_HOST_CLI_PROGRESS_H

#include <chrono>
#include <cstddef>
#include <string>

namespace selfproj::cli {

class StatusLine {
 public:
  StatusLine();
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;
  ~StatusLine();

  // Whether the line is shown.
  [[nodiscard]] bool visible() const { return terminal_; }

  void show(const std::string& text);

 private:
  bool terminal_;
  bool shown_ = false;
};

// Counts up, "frame 120 of 1400, 2 min left". If the total is 0 (unknown), it says "frame 120".
class Progress {
 public:
  Progress(std::string what, std::size_t total);

  // Updates the line at most ten times a second, with the note after the count.
  void update(std::size_t done, const std::string& note = {});

 private:
  std::string what_;
  std::size_t total_;
  StatusLine line_;
  std::chrono::steady_clock::time_point begin_;
  std::chrono::steady_clock::time_point next_;
};

// How long the rest takes if it goes on as so far, ", 2 min left"; empty in the first seconds, when nobody can know,
// and for less than a second. 0 < done < total.
std::string time_left(std::chrono::duration<double> so_far, std::size_t done, std::size_t total);

}  // namespace selfproj::cli

#endif  // SELFPROJ_HOST_CLI_PROGRESS_H
