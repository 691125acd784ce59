#include "host/capture/newest_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

namespace selfproj::capture {
namespace {

constexpr int kMaxSide = 1280;  // of the image on the page, in pixels

template <class Counts>
std::string share_text(const images::Image& image, const Counts& counts) {
  const auto count = std::count_if(image.pixels.begin(), image.pixels.end(), counts);
  const double pixels = static_cast<double>(std::max<std::size_t>(1, image.pixels.size()));
  return fmt::format("{:.1f} %", 100 * static_cast<double>(count) / pixels);
}

}  // namespace

void NewestImage::put(const camera::CameraImage& image, const camera::CameraCounters& counters,
                      const std::string& camera) {
  const std::lock_guard lock(mutex_);
  counters_ = counters;
  camera_ = camera;
  const double seconds = static_cast<double>(image.arrival_ns - last_ns_) * 1e-9;
  rate_ = last_ns_ > 0 && seconds > 0 ? 0.9 * rate_ + 0.1 / seconds : 0;
  last_ns_ = image.arrival_ns;
  if (!wanted_) {
    return;
  }
  picture_ = std::make_shared<images::Image>(images::copy_of(image.view));
  wanted_ = false;
  ++copies_;
  came_.notify_all();
}

std::shared_ptr<const images::Image> NewestImage::next() {
  constexpr std::chrono::milliseconds kPatience(500);
  std::unique_lock lock(mutex_);
  wanted_ = true;
  came_.wait_for(lock, kPatience, [this, before = copies_] { return copies_ > before; });
  return picture_;
}

std::shared_ptr<const std::string> NewestImage::png() {
  const std::shared_ptr<const images::Image> picture = next();
  const int every = std::max(1, (std::max(picture->rows, picture->columns) + kMaxSide - 1) / kMaxSide);
  images::Image shown{(picture->rows + every - 1) / every, (picture->columns + every - 1) / every, {}};
  for (int row = 0; row < picture->rows; row += every) {
    for (int column = 0; column < picture->columns; column += every) {
      shown.pixels.push_back(
          picture->pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(picture->columns) +
                          static_cast<std::size_t>(column)]);
    }
  }
  return std::make_shared<const std::string>(images::encode_png(shown));
}

std::shared_ptr<const std::string> NewestImage::figures() {
  const std::shared_ptr<const images::Image> picture = next();
  const std::lock_guard lock(mutex_);
  const nlohmann::ordered_json json = {
      {"camera", camera_},
      {"pixels", fmt::format("{} x {}", picture->columns, picture->rows)},
      {"images a second", fmt::format("{:.1f}", rate_)},
      {"saturated (255)", share_text(*picture, [](std::uint8_t pixel) { return pixel == UINT8_MAX; })},
      {"bright (200 or more)", share_text(*picture, [](std::uint8_t pixel) { return pixel >= 200; })},
      {"dark (below 20)", share_text(*picture, [](std::uint8_t pixel) { return pixel < 20; })},
      {"incomplete images", fmt::format("{}", counters_.incomplete)},
      {"dropped images", fmt::format("{}", counters_.dropped)}};
  return std::make_shared<const std::string>(json.dump());
}

std::uint64_t NewestImage::copies() const {
  const std::lock_guard lock(mutex_);
  return copies_;
}

}  // namespace selfproj::capture
