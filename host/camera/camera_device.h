// A camera and the board in software as a device of the driver.
#ifndef SELFPROJ_HOST_CAMERA_CAMERA_DEVICE_H
#define SELFPROJ_HOST_CAMERA_CAMERA_DEVICE_H

#include <memory>
#include <optional>
#include <string>

#include "host/camera/camera.h"
#include "host/camera/camera_uri.h"
#include "selfproj/driver/device.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/rig.h"

namespace selfproj::camera {

// Packets of the camera's images. The sequence is the camera's own number of the image, so that every image that it
// dropped is a missing frame; one of which parts are missing is a frame flagged as incomplete. The time stamp is the
// camera's time since the first image, in clocks of board.pixel_clock_hz. The encoder count is 0. The device has no
// end; next() throws UserError when the camera has gone.
//
// `board` has the settings; what is not given is that of BoardSettings. Throws UserError with the URI if no board
// could have images of the camera's size.
std::unique_ptr<driver::Device> make_camera_device(std::unique_ptr<Camera> camera, const CameraBoardSettings& board,
                                                   const driver::DeviceOptions& options = {});

// What a rig says of the camera and of the measurement, where the URI says nothing.
struct CameraDefaults {
  std::optional<images::ImagePart> region = {};
  CameraBoardSettings board = {};
};

// What a camera of a light section is set to: the size of the rig's camera, its pixel clock, and what to measure.
CameraDefaults camera_of_rig(const rig::Rig& rig, const model::Measure& measure);

// Gives a camera what its URI does not say. Throws UserError if its format has other bits than its pixels.
void fill_from(CameraUri& camera, const CameraDefaults& defaults);

// Opens a device of any kind: camera:NAME (camera_uri.h), or one of the driver (selfproj/driver/device.h). Throws
// UserError.
std::unique_ptr<driver::Device> open_any_device(const std::string& uri, const driver::DeviceOptions& options = {},
                                                const CameraDefaults& defaults = {});

}  // namespace selfproj::camera

#endif  // SELFPROJ_HOST_CAMERA_CAMERA_DEVICE_H
