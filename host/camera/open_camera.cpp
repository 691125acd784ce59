#include "host/camera/open_camera.h"

#include <fmt/format.h>

#include <memory>
#include <vector>

#include "host/camera/aravis_camera.h"
#include "host/camera/v4l2_camera.h"
#include "host/files/user_error.h"

namespace selfproj {

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

}  // namespace selfproj
