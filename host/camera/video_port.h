// The kernel's interface of a V4L2 camera, behind a seam, so that tests can put a player of recorded images in its
// place.
#ifndef SELFPROJ_HOST_CAMERA_VIDEO_PORT_H
#define SELFPROJ_HOST_CAMERA_VIDEO_PORT_H

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace selfproj {

class VideoPort {
 public:
  VideoPort() = default;
  VideoPort(const VideoPort&) = delete;
  VideoPort& operator=(const VideoPort&) = delete;
  virtual ~VideoPort() = default;

  // As ioctl(2) with a request of linux/videodev2.h: returns 0, or the number of the error (errno). Repeats what a
  // signal interrupted.
  virtual int control(unsigned long request, void* argument) = 0;

  // Memory of an image, as mmap(2); null if it cannot be mapped. It is unmapped with the port.
  virtual const std::uint8_t* map(std::size_t bytes, std::int64_t offset) = 0;

  // Waits until an image can be taken, no longer than this; returns false if none can.
  virtual bool wait(std::chrono::nanoseconds timeout) = 0;
};

// Opens the device file. Throws UserError with the path.
std::unique_ptr<VideoPort> open_video_port(const std::string& path);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAMERA_VIDEO_PORT_H
