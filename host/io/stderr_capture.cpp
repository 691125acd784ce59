#include "host/io/stderr_capture.h"

#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdio>
#include <string>

namespace selfproj {

StderrCapture::StderrCapture() : file_(std::tmpfile()) {
  if (file_ == nullptr) {
    return;
  }
  saved_ = dup(STDERR_FILENO);
  if (saved_ >= 0) {
    dup2(fileno(file_), STDERR_FILENO);
  }
}

StderrCapture::~StderrCapture() {
  if (saved_ >= 0) {
    dup2(saved_, STDERR_FILENO);
    close(saved_);
  }
  if (file_ != nullptr) {
    static_cast<void>(std::fclose(file_));
  }
}

std::string StderrCapture::text() const {
  std::string text;
  if (saved_ < 0) {
    return text;
  }
  std::array<char, 4096> block{};
  ssize_t count = 0;
  while ((count = pread(fileno(file_), block.data(), block.size(), static_cast<off_t>(text.size()))) > 0) {
    text.append(block.data(), static_cast<std::size_t>(count));
  }
  return text;
}

}  // namespace selfproj
