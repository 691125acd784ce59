#include "host/cli/status_line.h"

#include <unistd.h>

#include <cstdio>
#include <string>

namespace selfproj {

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

}  // namespace selfproj
