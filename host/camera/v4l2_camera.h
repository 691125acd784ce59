// Cameras of the kernel's interface V4L2, such as webcams.
#ifndef SELFPROJ_HOST_CAMERA_V4L2_CAMERA_H
#define SELFPROJ_HOST_CAMERA_V4L2_CAMERA_H

#include <memory>
#include <vector>

#include "host/camera/camera.h"
#include "host/camera/camera_list.h"
#include "host/camera/camera_uri.h"
#include "host/driver/device_port.h"

namespace selfproj {

// The devices /dev/video* that give images.
std::vector<CameraEntry> list_v4l2_cameras();

// Opens the device uri.name. Throws UserError with the URI if it gives no images, lacks the format, or refuses a
// setting. The format is Mono8 where the device has it, else the luminance of YUV422_8, unless the URI says another.
// There is no software trigger. Exposure times count in steps of 100 microseconds.
std::unique_ptr<Camera> open_v4l2_camera(const CameraUri& uri);

// The same on a port that is open.
std::unique_ptr<Camera> open_v4l2_camera(const CameraUri& uri, std::unique_ptr<DevicePort> port);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAMERA_V4L2_CAMERA_H
