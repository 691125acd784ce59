#ifndef SELFPROJ_HOST_IO_STDERR_CAPTURE_H
#define SELFPROJ_HOST_IO_STDERR_CAPTURE_H

#include <cstdio>
#include <string>

namespace selfproj {

// Takes what is written on standard error while it lives, so that the chatter of image libraries (libjpeg, libpng,
// OpenCV's log) does not come between the program's own lines, and can be looked at. For the whole process: not to be
// used while another thread writes there. Where the system gives no temporary file, nothing is captured.
class StderrCapture {
 public:
  StderrCapture();
  StderrCapture(const StderrCapture&) = delete;
  StderrCapture& operator=(const StderrCapture&) = delete;
  ~StderrCapture();

  // What has been written so far.
  [[nodiscard]] std::string text() const;

 private:
  std::FILE* file_;
  int saved_ = -1;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_STDERR_CAPTURE_H
