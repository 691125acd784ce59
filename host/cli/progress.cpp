#include "host/cli/progress.h"

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

bool Progress::due() const { return terminal_ && steady_clock::now() >= next_; }

void Progress::update(std::size_t done, const std::string& note) {
  if (!due()) {
    return;
  }
  next_ = steady_clock::now() + kInterval;
  shown_ = true;
  const std::string of = total_ > 0 ? " of " + std::to_string(total_) : std::string();
  static_cast<void>(std::fprintf(stderr, "\r%s %zu%s%s%s\033[K", what_.c_str(), done, of.c_str(),
                                 note.empty() ? "" : ": ", note.c_str()));
}

}  // namespace selfproj
