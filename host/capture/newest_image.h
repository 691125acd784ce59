// The newest image of a camera, from the thread that takes it to those that show it. An image is copied only when
// somebody has asked for one since the copy before.
#ifndef SELFPROJ_HOST_CAPTURE_NEWEST_IMAGE_H
#define SELFPROJ_HOST_CAPTURE_NEWEST_IMAGE_H

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

  // An image that came after the question, as PNG, each n-th pixel where it is large, and what is to be said of it, as
  // JSON. Both return null until it has come, and are then asked again; `asked` is 0 at first. If none comes for half a
  // second, they show the image before.
  std::shared_ptr<const std::string> png(std::uint64_t& asked);
  std::shared_ptr<const std::string> figures(std::uint64_t& asked);

  // Images copied so far.
  [[nodiscard]] std::uint64_t copies() const;

 private:
  // Whether there is an image for this question.
  bool has_come(std::uint64_t& asked);

  mutable std::mutex mutex_;
  bool wanted_ = false;
  std::int64_t wanted_ns_ = 0;
  std::uint64_t copies_ = 0;
  std::shared_ptr<const images::Image> picture_ = std::make_shared<images::Image>(images::Image{1, 1, {0}});
  camera::CameraCounters counters_;
  std::string camera_;
  // Of the picture, each made when it is asked for first.
  std::shared_ptr<const std::string> png_;
  std::shared_ptr<const std::string> figures_;
  double rate_ = 0;
  std::int64_t last_ns_ = 0;
};

}  // namespace selfproj::capture

#endif  // SELFPROJ_HOST_CAPTURE_NEWEST_IMAGE_H
