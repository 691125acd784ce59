// Cameras: one interface to whatever gives images. open_camera.h opens one by its URI.
//
//     const std::unique_ptr<Camera> camera = open_camera(parse_camera_uri("camera:192.168.1.20?exposure-us=500"));
//     camera->start();
//     CameraImage image;
//     while (camera->next(image, 100ms)) {
//       ... image.view, image.number ...
//     }
#ifndef SELFPROJ_HOST_CAMERA_CAMERA_H
#define SELFPROJ_HOST_CAMERA_CAMERA_H

#include <chrono>
#include <cstdint>
#include <string>

#include "selfproj/model/column_moments.h"

namespace selfproj::camera {

// An image of the camera, in 8 bits, and of a camera that was opened for more bits in these, too.
struct CameraImage {
  model::ImageView view;           // valid until the next call of next() or stop()
  model::WideImageView wide = {};  // all bits, as long; null without them
  std::uint64_t number = 0;        // the camera's own number, without its wrap; from 0 at the first image after start()
  std::int64_t time_ns = 0;        // the camera's clock when it took the image; it never runs backwards
  std::int64_t arrival_ns = 0;     // when it came in, by the clock of host/driver/clock.h
  bool complete = false;           // otherwise parts are missing, and the pixels mean nothing
};

// What became of the images since start(): each number that the camera gave is in exactly one of the first three.
struct CameraCounters {
  std::uint64_t complete = 0;    // images given out whole
  std::uint64_t incomplete = 0;  // images given out with parts missing
  std::uint64_t dropped = 0;     // numbers between two images given out, which never came
  std::uint64_t late = 0;        // of these, images that came after a later one, and were not given out

  bool operator==(const CameraCounters&) const = default;
};

// For one thread at a time. A camera that goes away or fails makes every call throw UserError with its URI.
class Camera {
 public:
  Camera() = default;
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;
  virtual ~Camera() = default;  // stops it, and leaves its trigger and automatics as they were found

  // Begins to take images; counts from 0 again.
  virtual void start() = 0;
  virtual void stop() = 0;

  // Asks for one image, where the camera was opened with Trigger::software. Throws std::logic_error while an earlier
  // request is under way, because cameras merge triggers that come too fast: a request ends with its image, or with
  // forget_trigger().
  virtual void trigger() = 0;

  // Gives the request up, because its image did not come. Images that come until then are of no use.
  virtual void forget_trigger() = 0;

  // Gives the next image, complete or not. Returns false if none has come in time; with 0 it looks once.
  virtual bool next(CameraImage& image, std::chrono::nanoseconds timeout) = 0;

  [[nodiscard]] virtual CameraCounters counters() const = 0;

  // The size of its images after the settings, and after the channel of a colour format was taken.
  [[nodiscard]] virtual int rows() const = 0;
  [[nodiscard]] virtual int columns() const = 0;

  // Without its parameters, such as "camera:192.168.1.20".
  [[nodiscard]] virtual const std::string& uri() const = 0;
};

}  // namespace selfproj::camera

#endif  // SELFPROJ_HOST_CAMERA_CAMERA_H
