// Single images of a camera, each taken after a given time.
#ifndef SELFPROJ_HOST_CAPTURE_SHOTS_H
#define SELFPROJ_HOST_CAPTURE_SHOTS_H

#include <cstdint>
#include <stdexcept>
#include <string>

#include "host/camera/camera.h"
#include "host/capture/projector.h"
#include "host/images/image_files.h"

namespace selfproj::capture {

// Esc or Ctrl-C ended a capture.
class Stopped : public std::runtime_error {
 public:
  Stopped() : std::runtime_error("stopped before the end, and nothing is written") {}
};

// What had to be taken again.
struct ShotCounters {
  std::uint64_t incomplete = 0;  // images of which parts were lost
  std::uint64_t missing = 0;     // software triggers whose image did not come
  std::uint64_t mixed = 0;       // images of a pattern and its negative that were not those of these two
};

class Shots {
 public:
  // `triggered`: the camera was opened with its software trigger; otherwise it runs free. Both must outlive this.
  Shots(Projector& projector, camera::Camera& camera, bool triggered)
      : projector_(projector), camera_(camera), triggered_(triggered) {}

  // Shows a pattern or a grey, and returns the time when the system had taken it.
  std::int64_t show(const images::Image& pattern, const std::string& name);
  std::int64_t show(std::uint8_t grey);

  // Takes a whole image no earlier than at this time of host/driver/clock.h: triggered then, or of a camera that runs
  // free the first that came in after it. Takes again what is incomplete or does not come; throws UserError about the
  // camera after 20 tries, and Stopped.
  const images::Image& take_after(std::int64_t time_ns);

  // When the last image was triggered, or of a camera that runs free when it came in.
  [[nodiscard]] std::int64_t taken_ns() const { return taken_ns_; }

  // When the last image came in.
  [[nodiscard]] std::int64_t arrived_ns() const { return arrived_ns_; }

  // Waits, and throws Stopped.
  void wait_until(std::int64_t time_ns);

  void count_mixed(std::uint64_t images) { counters_.mixed += images; }

  [[nodiscard]] const ShotCounters& counters() const { return counters_; }

 private:
  bool try_once(std::int64_t time_ns);
  bool next(camera::CameraImage& image);
  void check_stopped();

  Projector& projector_;
  camera::Camera& camera_;
  bool triggered_;
  images::Image image_;
  std::int64_t taken_ns_ = 0;
  std::int64_t arrived_ns_ = 0;
  ShotCounters counters_;
};

// The mean grey of an image.
double mean_grey(const images::Image& image);

}  // namespace selfproj::capture

#endif  // SELFPROJ_HOST_CAPTURE_SHOTS_H
