// GigE Vision and USB3 Vision cameras, through Aravis.
#ifndef SELFPROJ_HOST_CAMERA_ARAVIS_CAMERA_H
#define SELFPROJ_HOST_CAMERA_ARAVIS_CAMERA_H

#include <memory>
#include <vector>

#include "host/camera/camera.h"
#include "host/camera/camera_list.h"
#include "host/camera/camera_uri.h"

namespace selfproj {

// Whether the program was built with Aravis.
bool has_aravis();

// The cameras that answer within a second; none if the program was built without Aravis.
std::vector<CameraEntry> list_aravis_cameras();

// Opens the camera of this name or network address; "Fake_1" is one that Aravis simulates within the program. Throws
// UserError with the URI if it is not there, another program has it, it refuses a setting, or the program was built
// without Aravis.
std::unique_ptr<Camera> open_aravis_camera(const CameraUri& uri);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAMERA_ARAVIS_CAMERA_H
