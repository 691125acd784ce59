#include "host/cli/program_run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <functional>
#include <iostream>
#include <string>

#include "host/files/file_descriptor.h"
#include "host/files/run_files.h"
#include "host/files/stop_signal.h"

namespace selfproj {
namespace {

// If a standard descriptor is closed, the first file that is opened would get its number, and printed text would go
// into this file. Opens /dev/null instead, so that reading gives nothing and writing to standard output fails.
void open_standard_descriptors() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(number, F_GETFD) < 0 && errno == EBADF) {
      // open() takes the lowest free number.
      static_cast<void>(open("/dev/null", number == STDERR_FILENO ? O_WRONLY : O_RDONLY));
    }
  }
}

// Flushes standard output, and returns whether everything could be printed.
bool flush_output() {
  errno = 0;
  const bool stream = static_cast<bool>(std::cout.flush());
  return std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && stream;
}

}  // namespace

int run_as_program(const std::string& name, const std::function<int()>& body) {
  open_standard_descriptors();
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  tidy_up_on_signals();
  const RunFiles files;
  const int status = body();
  if (!flush_output() && status == 0) {
    fmt::print(stderr, "{}: standard output: {}\n", name, error_text(errno != 0 ? errno : EIO));
    return 1;
  }
  return status;
}

}  // namespace selfproj
