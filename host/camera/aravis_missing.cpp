// In place of aravis_camera.cpp where Aravis is not installed.
#include <memory>
#include <vector>

#include "host/camera/aravis_camera.h"
#include "host/files/user_error.h"

namespace selfproj {

bool has_aravis() { return false; }

std::vector<CameraEntry> list_aravis_cameras() { return {}; }

std::unique_ptr<Camera> open_aravis_camera(const CameraUri& uri) {
  throw UserError(uri.uri, "built without Aravis, this program knows no GigE and USB3 cameras, but those of V4L2");
}

}  // namespace selfproj
