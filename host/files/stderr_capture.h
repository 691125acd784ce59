#ifndef SELFPROJ_HOST_FILES_STDERR_CAPTURE_H
#define SELFPROJ_HOST_FILES_STDERR_CAPTURE_H

#include <string>

#include "host/files/file_descriptor.h"

namespace selfproj::files {

// Captures standard error while it lives, so that messages of image libraries (libjpeg, libpng, OpenCV's log) do not
// mix with the program's own lines, and can be read. It captures for the whole process, so no other thread may write
// there meanwhile. It uses a pipe, which needs no disk, is not subject to limits on file sizes, and holds the first 64
// KiB. Standard error may be open or closed. Throws std::runtime_error if the system gives no pipe, because a decoder's
// report of damage must not be missed.
class StderrCapture {
 public:
  StderrCapture();
  StderrCapture(const StderrCapture&) = delete;
  StderrCapture& operator=(const StderrCapture&) = delete;
  ~StderrCapture();

  // The text written so far.
  [[nodiscard]] const std::string& text();

 private:
  FileDescriptor pipe_{-1};  // the end from which it is read
  int saved_ = -1;           // the original standard error; -1 if it was closed
  std::string text_;
};

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_STDERR_CAPTURE_H
