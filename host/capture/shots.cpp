#include "host/capture/shots.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <numeric>
#include <string>
#include <thread>

#include "host/driver/clock.h"
#include "host/files/stop_signal.h"
#include "selfproj/files/user_error.h"

namespace selfproj::capture {
namespace {

constexpr int kMaxTries = 20;
constexpr std::int64_t kPatience = 3'000'000'000;  // ns, for an image; exposures of a camera are shorter
constexpr std::chrono::milliseconds kLook(20);     // so that Esc and Ctrl-C are noticed

}  // namespace

std::int64_t Shots::show(const images::Image& pattern, const std::string& name) {
  projector_.show(pattern, name);
  return driver::now_ns();
}

std::int64_t Shots::show(std::uint8_t grey) {
  projector_.show(grey);
  return driver::now_ns();
}

void Shots::check_stopped() {
  if (projector_.stopped() || files::StopSignal::came()) {
    throw Stopped();
  }
}

void Shots::wait_until(std::int64_t time_ns) {
  for (;;) {
    check_stopped();
    const std::int64_t rest = time_ns - driver::now_ns();
    if (rest <= 0) {
      return;
    }
    std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(std::chrono::nanoseconds(rest), kLook));
  }
}

// The next image, or false after kPatience.
bool Shots::next(camera::CameraImage& image) {
  const std::int64_t end = driver::now_ns() + kPatience;
  while (driver::now_ns() < end) {
    check_stopped();
    if (camera_.next(image, kLook)) {
      return true;
    }
  }
  return false;
}

bool Shots::try_once(std::int64_t time_ns) {
  camera::CameraImage image;
  if (triggered_) {
    wait_until(time_ns);
    taken_ns_ = driver::now_ns();
    camera_.trigger();
    if (!next(image)) {
      camera_.forget_trigger();
      ++counters_.missing;
      return false;
    }
  } else {
    do {
      if (!next(image)) {
        throw UserError(camera_.uri(), "sends no images");
      }
    } while (image.arrival_ns < time_ns);
    taken_ns_ = image.arrival_ns;
  }
  if (!image.complete) {
    ++counters_.incomplete;
    return false;
  }
  arrived_ns_ = image.arrival_ns;
  image_ = images::copy_of(image.view);
  return true;
}

const images::Image& Shots::take_after(std::int64_t time_ns) {
  for (int i = 0; i < kMaxTries; ++i) {
    if (try_once(time_ns)) {
      return image_;
    }
  }
  throw UserError(camera_.uri(), fmt::format("{} images in a row were incomplete or missing", kMaxTries));
}

double mean_grey(const images::Image& image) {
  const auto sum = std::accumulate(image.pixels.begin(), image.pixels.end(), std::uint64_t{0});
  return static_cast<double>(sum) / static_cast<double>(image.pixels.size());
}

}  // namespace selfproj::capture
