#include "host/io/progress.h"

#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>

namespace selfproj {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kInterval{100};

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) != 0),
      next_(steady_clock::now() + kInterval) {}

Progress::~Progress() {
  if (shown_) {
    static_cast<void>(std::fputs("\r\033[K", stderr));
  }
}

void Progress::update(std::size_t done, const std::string& note) {
  if (!terminal_ || steady_clock::now() < next_) {
    return;
  }
  next_ = steady_clock::now() + kInterval;
  shown_ = true;
  static_cast<void>(std::fprintf(stderr, "\r%s %zu of %zu%s%s\033[K", what_.c_str(), done, total_,
                                 note.empty() ? "" : ": ", note.c_str()));
}

}  // namespace selfproj
