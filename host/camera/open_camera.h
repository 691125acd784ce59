// The cameras of this machine and its network.
#ifndef SELFPROJ_HOST_CAMERA_OPEN_CAMERA_H
#define SELFPROJ_HOST_CAMERA_OPEN_CAMERA_H

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/camera/camera.h"
#include "host/camera/camera_uri.h"
#include "host/camera/frame_numbers.h"
#include "host/camera/pixel_format.h"
#include "host/driver/device_port.h"

namespace selfproj::camera {

struct CameraEntry {
  std::string uri;      // for --device and --camera
  std::string kind;     // "GigE Vision", "USB3 Vision", "V4L2"
  std::string model;    // its maker and model, as it says
  std::string address;  // in the network, on the bus, or its path
  std::string problem;  // why it cannot be used; empty if nothing is known
};

// The cameras there are; takes a second, in which cameras of the network answer.
std::vector<CameraEntry> list_cameras();

// Opens a camera: a name that begins with /dev/ is a V4L2 device, any other belongs to Aravis. Throws UserError with
// the URI if it cannot be opened, refuses a setting, or has no name and there is not exactly one camera.
std::unique_ptr<Camera> open_camera(const CameraUri& uri);

// What the kinds of cameras have in common.
class FormattedCamera : public Camera {
 public:
  FormattedCamera(const CameraUri& uri, CameraParameters settings) : uri_(uri.uri), settings_(std::move(settings)) {}

  [[nodiscard]] CameraCounters counters() const override { return counters_; }
  [[nodiscard]] int rows() const override { return rows_of(format_, raw_rows_); }
  [[nodiscard]] int columns() const override { return columns_of(format_, raw_columns_); }
  [[nodiscard]] const std::string& uri() const override { return uri_; }

 protected:
  // Throws UserError unless the camera has taken the region of the settings.
  void check_region() const;

  // Describes an image whose lines are `stride` bytes apart, and counts it; a line may be longer than its pixels.
  void describe(CameraImage& image, std::span<const std::uint8_t> raw, std::size_t stride, bool complete);

  std::string uri_;
  CameraParameters settings_;
  PixelFormat format_{};
  int raw_rows_ = 0;
  int raw_columns_ = 0;
  FrameNumbers numbers_{0, 0};
  CameraCounters counters_;
  std::int64_t last_time_ = 0;  // of the camera

 private:
  std::vector<std::uint8_t> pixels_;  // of an image that is not plain
  std::vector<std::uint16_t> words_;  // all bits of its pixels
};

// Whether the program was built with Aravis.
bool has_aravis();

// The cameras that answer within a second; none if the program was built without Aravis.
std::vector<CameraEntry> list_aravis_cameras();

// Opens the camera of this name or network address; "Fake_1" is one that Aravis simulates within the program. Throws
// UserError with the URI if it is not there, another program has it, it refuses a setting, or the program was built
// without Aravis.
std::unique_ptr<Camera> open_aravis_camera(const CameraUri& uri);

// The devices /dev/video* that give images.
std::vector<CameraEntry> list_v4l2_cameras();

// Opens the device uri.name. Throws UserError with the URI if it gives no images, lacks the format, or refuses a
// setting. The format is Mono8 where the device has it, else the luminance of YUV422_8, unless the URI says another.
// There is no software trigger. Exposure times count in steps of 100 microseconds.
std::unique_ptr<Camera> open_v4l2_camera(const CameraUri& uri);

// The same on a port that is open.
std::unique_ptr<Camera> open_v4l2_camera(const CameraUri& uri, std::unique_ptr<driver::DevicePort> port);

}  // namespace selfproj::camera

#endif  // SELFPROJ_HOST_CAMERA_OPEN_CAMERA_H
