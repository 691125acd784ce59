#ifndef SELFPROJ_HOST_IO_STDERR_CAPTURE_H
#define SELFPROJ_HOST_IO_STDERR_CAPTURE_H

#include <string>

#include "host/io/file_descriptor.h"

namespace selfproj {

// Takes what is written on standard error while it lives, so that the chatter of image libraries (libjpeg, libpng,
// OpenCV's log) does not come between the program's own lines, and can be looked at. For the whole process: not to be
// used while another thread writes there. It goes through a pipe, which needs no disk, knows no limit on sizes of
// files, and holds the first 64 KiB; whether standard error is open does not matter. Throws std::runtime_error where
// the system gives no pipe: what a decoder says of damage must not go by unseen.
class StderrCapture {
 public:
  StderrCapture();
  StderrCapture(const StderrCapture&) = delete;
  StderrCapture& operator=(const StderrCapture&) = delete;
  ~StderrCapture();

  // What has been written so far.
  [[nodiscard]] const std::string& text();

 private:
  FileDescriptor pipe_{-1};  // where it is read
  int saved_ = -1;           // standard error; -1 where it was closed
  std::string text_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_STDERR_CAPTURE_H
