#include "host/gentl/camera.h"

#include <utility>

#include "host/camera/camera_uri.h"
#include "host/driver/open_control.h"
#include "host/files/user_error.h"
#include "host/gentl/gentl_errors.h"

namespace selfproj::gentl {

Camera::Camera(const DeviceEntry& entry, bool writable)
    : Module("Device", entry.id), entry_(entry), writable_(writable), source_(entry) {
  open_board(entry);
}

// A control that was named must answer. Without one that belongs to the device the settings can only be read.
void Camera::open_board(const DeviceEntry& entry) {
  if (!entry.control.empty()) {
    control_ = open_control(entry.control);
    return;
  }
  if (is_camera_uri(entry.id)) {
    control_problem_ = "none: " + entry.id + " is a camera without a board; its settings stand behind '?'";
    return;
  }
  const std::string control = control_uri(entry.id);
  if (control.empty()) {
    control_problem_ = "none: " + entry.id + " has no control of a board beside it";
    return;
  }
  try {
    control_ = open_control(control);
  } catch (const UserError& error) {
    control_problem_ = std::string("none: ") + error.what();
  }
}

FrameLayout Camera::layout() const {
  return {.columns = source_.rig().camera.columns,
          .height = height_,
          .range = range_,
          .intensity = intensity_,
          .abc = abc_,
          .chunks = chunks_};
}

void Camera::set_running(bool running) {
  {
    const std::lock_guard lock(gate_.mutex);
    gate_.running = running;
  }
  gate_.changed.notify_all();
}

void Camera::enable(bool on) {
  const bool other = component_ == kRangeId ? intensity_ : range_;
  require(on || other, GC_ERR_INVALID_VALUE, "ComponentEnable: at least one component must be enabled");
  enabled() = on;
}

std::int64_t Camera::format() const {
  return static_cast<std::int64_t>(component_ == kIntensityId ? kMono16 : abc_ ? kCoord3dAbc32f : kCoord3dC32f);
}

void Camera::set_format(std::int64_t format) {
  if (component_ == kRangeId) {
    abc_ = format == static_cast<std::int64_t>(kCoord3dAbc32f);
  }
}

void Camera::add_setting(FeatureSet& features, Feature feature, const std::string& part,
                         std::function<std::int64_t(const Measure&)> told) {
  feature.category = "Measurement";
  feature.standard = false;
  feature.locked_by = "BoardControlMissing";
  feature.get = [this, part, told = std::move(told)] {
    return control_ != nullptr ? std::int64_t{control_->read(part)} : told(source_.newest());
  };
  feature.set = [this, part](std::int64_t value) { control_->write(part, static_cast<std::uint32_t>(value)); };
  features.add(std::move(feature));
}

void Camera::describe(FeatureSet& features) {
  describe_device(features);
  describe_image(features);
  describe_acquisition(features);
  describe_scan3d(features);
  describe_measurement(features);
  describe_counters(features);
  describe_chunks(features);
}

}  // namespace selfproj::gentl
