#include "host/capture/newest_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "host/driver/clock.h"
#include "host/files/json_text.h"

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
  png_ = figures_ = nullptr;
  ++copies_;
}

bool NewestImage::has_come(std::uint64_t& asked) {
  constexpr std::int64_t kPatienceNs = 500'000'000;
  if (asked == 0) {
    asked = copies_ + 1;
    wanted_ns_ = wanted_ ? wanted_ns_ : driver::now_ns();
    wanted_ = true;
  }
  return copies_ >= asked || driver::now_ns() - wanted_ns_ > kPatienceNs;
}

std::shared_ptr<const std::string> NewestImage::png(std::uint64_t& asked) {
  const std::lock_guard lock(mutex_);
  if (!has_come(asked)) {
    return nullptr;
  }
  if (png_ == nullptr) {
    const int every = std::max(1, (std::max(picture_->rows, picture_->columns) + kMaxSide - 1) / kMaxSide);
    images::Image shown{(picture_->rows + every - 1) / every, (picture_->columns + every - 1) / every, {}};
    for (int row = 0; row < picture_->rows; row += every) {
      for (int column = 0; column < picture_->columns; column += every) {
        shown.pixels.push_back(
            picture_->pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(picture_->columns) +
                             static_cast<std::size_t>(column)]);
      }
    }
    png_ = std::make_shared<const std::string>(images::encode_png(shown));
  }
  return png_;
}

std::shared_ptr<const std::string> NewestImage::figures(std::uint64_t& asked) {
  const std::lock_guard lock(mutex_);
  if (!has_come(asked)) {
    return nullptr;
  }
  if (figures_ == nullptr) {
    const nlohmann::ordered_json json = {
        {"camera", camera_},
        {"pixels", fmt::format("{} x {}", picture_->columns, picture_->rows)},
        {"images a second", fmt::format("{:.1f}", rate_)},
        {"saturated (255)", share_text(*picture_, [](std::uint8_t pixel) { return pixel == UINT8_MAX; })},
        {"bright (200 or more)", share_text(*picture_, [](std::uint8_t pixel) { return pixel >= 200; })},
        {"dark (below 20)", share_text(*picture_, [](std::uint8_t pixel) { return pixel < 20; })},
        {"incomplete images", fmt::format("{}", counters_.incomplete)},
        {"dropped images", fmt::format("{}", counters_.dropped)}};
    figures_ = std::make_shared<const std::string>(files::json_text(json));
  }
  return figures_;
}

std::uint64_t NewestImage::copies() const {
  const std::lock_guard lock(mutex_);
  return copies_;
}

}  // namespace selfproj::capture
