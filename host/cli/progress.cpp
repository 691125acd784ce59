#include "host/cli/progress.h"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>

namespace selfproj::cli {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kInterval{100};

StatusLine::StatusLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

StatusLine::~StatusLine() {
  if (shown_) {
    static_cast<void>(std::fputs("\r\033[K", stderr));
  }
}

void StatusLine::show(const std::string& text) {
  if (terminal_) {
    shown_ = true;
    static_cast<void>(std::fprintf(stderr, "\r%s\033[K", text.c_str()));
  }
}

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)), total_(total), begin_(steady_clock::now()), next_(begin_ + kInterval) {}

std::string time_left(std::chrono::duration<double> so_far, std::size_t done, std::size_t total) {
  constexpr double kFirst = 2;
  const double seconds = so_far.count() * static_cast<double>(total - done) / static_cast<double>(done);
  if (so_far.count() < kFirst || seconds < 1) {
    return "";
  }
  const auto text = [](double number, const char* unit) {
    return ", " + std::to_string(std::lround(number)) + unit + " left";
  };
  constexpr double kMinute = 60;
  return seconds < 2 * kMinute             ? text(seconds, " s")
         : seconds < 2 * kMinute * kMinute ? text(seconds / kMinute, " min")
                                           : text(seconds / kMinute / kMinute, " h");
}

void Progress::update(std::size_t done, const std::string& note) {
  if (!line_.visible() || steady_clock::now() < next_) {
    return;
  }
  next_ = steady_clock::now() + kInterval;
  line_.show(what_ + " " + std::to_string(done) + (total_ > 0 ? " of " + std::to_string(total_) : "") +
             (done > 0 && done < total_ ? time_left(steady_clock::now() - begin_, done, total_) : "") +
             (note.empty() ? "" : ": " + note));
}

}  // namespace selfproj::cli
