#include "host/files/stderr_capture.h"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "host/files/file_descriptor.h"

namespace selfproj::files {

StderrCapture::StderrCapture() {
  static_cast<void>(std::fflush(stderr));
  saved_ = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  const bool closed = saved_ < 0 && errno == EBADF;
  std::array<int, 2> ends{-1, -1};
  // Non-blocking: a library that writes more than the pipe holds does not wait for a reader.
  bool done = (saved_ >= 0 || closed) && pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) == 0;
  if (done && ends[0] == STDERR_FILENO) {  // standard error was closed, and the pipe got its number
    ends[0] = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    done = ends[0] >= 0;
  }
  done = done && dup2(ends[1], STDERR_FILENO) >= 0;
  const int error = errno;
  if (ends[1] >= 0 && ends[1] != STDERR_FILENO) {
    close(ends[1]);
  }
  pipe_.reset(ends[0]);
  if (!done) {
    if (saved_ >= 0) {
      close(saved_);
    }
    throw std::runtime_error("standard error cannot be looked at: " + error_text(error));
  }
}

StderrCapture::~StderrCapture() {
  static_cast<void>(std::fflush(stderr));
  std::clearerr(stderr);
  if (saved_ >= 0) {
    dup2(saved_, STDERR_FILENO);
    close(saved_);
  } else {
    close(STDERR_FILENO);
  }
}

const std::string& StderrCapture::text() {
  static_cast<void>(std::fflush(stderr));
  std::array<char, 4096> block{};
  ssize_t count = 0;
  while ((count = read(pipe_.number(), block.data(), block.size())) > 0) {
    text_.append(block.data(), static_cast<std::size_t>(count));
  }
  return text_;
}

}  // namespace selfproj::files
