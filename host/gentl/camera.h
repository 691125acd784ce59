// The remote device: the camera that a consumer sees, with its features.
#ifndef SELFPROJ_HOST_GENTL_CAMERA_H
#define SELFPROJ_HOST_GENTL_CAMERA_H

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "host/driver/control.h"
#include "host/gentl/buffer.h"
#include "host/gentl/line_source.h"
#include "host/gentl/module.h"

namespace selfproj::gentl {

// Connects the features AcquisitionStart and AcquisitionStop with the thread that acquires.
struct AcquisitionGate {
  std::mutex mutex;
  std::condition_variable changed;
  bool running = false;  // under the mutex
};

class Camera final : public Module {
 public:
  // Throws as LineSource does, and UserError if the entry names a control that does not answer.
  Camera(const DeviceEntry& entry, bool writable);

  [[nodiscard]] std::string model() const override { return source_.rig().name; }
  [[nodiscard]] bool writable() const override { return writable_; }

  [[nodiscard]] FrameLayout layout() const;
  [[nodiscard]] bool belt_carried() const { return belt_carried_; }
  [[nodiscard]] LineSource& source() { return source_; }
  [[nodiscard]] AcquisitionGate& gate() { return gate_; }
  void set_running(bool running);

 private:
  void describe(FeatureSet& features) override;
  void describe_device(FeatureSet& features);
  void describe_image(FeatureSet& features);
  void describe_acquisition(FeatureSet& features);
  void describe_scan3d(FeatureSet& features);
  void describe_measurement(FeatureSet& features);
  void describe_counters(FeatureSet& features);
  void describe_chunks(FeatureSet& features);

  [[nodiscard]] bool& enabled() { return component_ == kRangeId ? range_ : intensity_; }
  void enable(bool on);
  [[nodiscard]] std::int64_t format() const;
  void set_format(std::int64_t format);
  void open_board(const DeviceEntry& entry);
  void add_setting(FeatureSet& features, Feature feature, const std::string& part,
                   std::function<std::int64_t(const model::Measure&)> reported);

  DeviceEntry entry_;
  bool writable_;
  LineSource source_;
  std::unique_ptr<driver::Control> control_;  // null: the settings of the measurement can only be read
  std::string control_problem_;
  AcquisitionGate gate_;
  bool locked_ = false;  // TLParamsLocked
  int height_ = 64;
  std::int64_t component_ = kRangeId;
  std::int64_t coordinate_ = 0;
  bool range_ = true;
  bool intensity_ = false;
  bool abc_ = true;
  bool chunks_ = false;
  bool belt_carried_ = true;
};

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_CAMERA_H
