#include "host/camera/open_camera.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "selfproj/files/user_error.h"

namespace selfproj::camera {

void FormattedCamera::check_region() const {
  if (settings_.region && (settings_.region->columns != raw_columns_ || settings_.region->rows != raw_rows_)) {
    throw UserError(uri_, fmt::format("region: the camera takes {} x {} pixels instead", raw_columns_, raw_rows_));
  }
}

void FormattedCamera::describe(CameraImage& image, std::span<const std::uint8_t> raw, std::size_t stride,
                               bool complete) {
  image.complete = complete;
  ++(complete ? counters_.complete : counters_.incomplete);
  if (is_plain(format_)) {
    image.view = {raw.data(), rows(), columns(), static_cast<std::ptrdiff_t>(stride)};
    return;
  }
  pixels_.resize(static_cast<std::size_t>(rows()) * static_cast<std::size_t>(columns()));
  if (complete) {
    to_grey8(format_, settings_.channel, raw, raw_rows_, raw_columns_, stride, pixels_.data());
  }
  image.view = {pixels_.data(), rows(), columns(), columns()};
  if (settings_.bits > spec::kPixelBits) {
    words_.resize(pixels_.size());
    if (complete) {
      to_words(format_, raw, raw_rows_, raw_columns_, stride, words_.data());
    }
    image.wide = {words_.data(), rows(), columns(), columns()};
  }
}

std::vector<CameraEntry> list_cameras() {
  std::vector<CameraEntry> cameras = list_aravis_cameras();
  const std::vector<CameraEntry> video = list_v4l2_cameras();
  cameras.insert(cameras.end(), video.begin(), video.end());
  return cameras;
}

std::unique_ptr<Camera> open_camera(const CameraUri& uri) {
  if (uri.name.empty()) {
    const std::vector<CameraEntry> cameras = list_cameras();
    if (cameras.size() != 1) {
      throw UserError(uri.uri,
                      fmt::format("there are {} cameras; `selfproj devices` lists their names", cameras.size()));
    }
    CameraUri one = uri;
    one.uri = cameras.front().uri;
    one.name = one.uri.substr(uri.uri.size());
    return open_camera(one);
  }
  return uri.name.starts_with("/dev/") ? open_v4l2_camera(uri) : open_aravis_camera(uri);
}

#ifndef SELFPROJ_HAS_ARAVIS

bool has_aravis() { return false; }

std::vector<CameraEntry> list_aravis_cameras() { return {}; }

std::unique_ptr<Camera> open_aravis_camera(const CameraUri& uri) {
  throw UserError(uri.uri, "built without Aravis, this program knows no GigE and USB3 cameras, but those of V4L2");
}

#endif

}  // namespace selfproj::camera
