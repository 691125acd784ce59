#ifndef SELFPROJ_HOST_CAMERA_OPEN_CAMERA_H
#define SELFPROJ_HOST_CAMERA_OPEN_CAMERA_H

#include <memory>
#include <vector>

#include "host/camera/camera.h"
#include "host/camera/camera_list.h"
#include "host/camera/camera_uri.h"

namespace selfproj {

// The cameras there are; takes a second, in which cameras of the network answer.
std::vector<CameraEntry> list_cameras();

// Opens a camera: a name that begins with /dev/ is a V4L2 device, any other belongs to Aravis. Throws UserError with
// the URI if it cannot be opened, refuses a setting, or has no name and there is not exactly one camera.
std::unique_ptr<Camera> open_camera(const CameraUri& uri);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAMERA_OPEN_CAMERA_H
