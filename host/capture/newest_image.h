// The newest image of a camera, from the thread that takes it to those that show it. An image is copied only when
// somebody has asked for one since the copy before.
#ifndef SELFPROJ_HOST_CAPTURE_NEWEST_IMAGE_H
#define SELFPROJ_HOST_CAPTURE_NEWEST_IMAGE_H

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "host/camera/camera.h"
#include "host/images/image_files.h"

namespace selfproj::capture {

class NewestImage {
 public:
  // Offers an image. Costs no copy where nobody watches.
  void put(const camera::CameraImage& image, const camera::CameraCounters& counters, const std::string& camera);

  // The next image as PNG, each n-th pixel where it is large, and what is to be said of it, as JSON. Both wait up to
  // half a second for an image; without one they show the image before.
  std::shared_ptr<const std::string> png();
  std::shared_ptr<const std::string> figures();

  // Images copied so far.
  [[nodiscard]] std::uint64_t copies() const;

 private:
  std::shared_ptr<const images::Image> next();

  mutable std::mutex mutex_;
  std::condition_variable came_;
  bool wanted_ = false;
  std::uint64_t copies_ = 0;
  std::shared_ptr<const images::Image> picture_ = std::make_shared<images::Image>(images::Image{1, 1, {0}});
  camera::CameraCounters counters_;
  std::string camera_;
  double rate_ = 0;
  std::int64_t last_ns_ = 0;
};

}  // namespace selfproj::capture

#endif  // SELFPROJ_HOST_CAPTURE_NEWEST_IMAGE_H
