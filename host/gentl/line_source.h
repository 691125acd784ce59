// Lines of 3-D points from the packets of a device.
#ifndef SELFPROJ_HOST_GENTL_LINE_SOURCE_H
#define SELFPROJ_HOST_GENTL_LINE_SOURCE_H

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "host/gentl/device_list.h"
#include "host/production/belt_position.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::gentl {

// What the driver counts, and what the source itself counts.
struct SourceCounts {
  driver::Counters driver;
  std::uint64_t other_size = 0;   // frames of another size, or of pixels of other bits, than the rig's camera
  std::uint64_t not_moments = 0;  // packets of images and codes
};

// Only one thread at a time may call next() and use the line that it gives. Any thread may call counts() and newest().
class LineSource {
 public:
  // Opens the device, and looks at its first packet if there is one. Throws UserError if the device, the rig or the
  // reference cannot be used, and GC_ERR_RESOURCE_IN_USE if another reader has the device.
  explicit LineSource(const DeviceEntry& entry);

  // Gives the next frame as a line. Broken frames, frames of another size, and packets without moments are counted and
  // left out. Throws UserError if the first frame has another size than the rig's camera.
  driver::Next next(std::chrono::nanoseconds timeout);

  // The line that next() gave: its header, its points, and how many pixels of each column are lit. x is in the camera's
  // coordinates. If it is carried back, the way of the belt since begin() is subtracted, as in the clouds of
  // `selfproj inspect`.
  [[nodiscard]] const model::PacketHeader& header() const { return header_; }
  [[nodiscard]] const light_section::Profile& profile() const { return profile_; }
  [[nodiscard]] const std::vector<std::uint32_t>& lit() const { return runs_.moments.n; }

  // Sets the belt's position to 0 at the next line. `carried`: x is carried back.
  void begin(bool carried);

  [[nodiscard]] const rig::Rig& rig() const { return rig_; }
  [[nodiscard]] const std::string& uri() const { return device_->uri(); }

  // The counts at the last call of next().
  [[nodiscard]] SourceCounts counts() const;
  // The settings of the measurement in the newest frame; before the first frame those of the URI or the rig.
  [[nodiscard]] model::Measure newest() const;

 private:
  bool usable(const model::PacketView& packet);
  driver::Next look(std::chrono::nanoseconds timeout);
  void note();
  void compute_line();

  rig::Rig rig_;
  light_section::DifferentialProfiler profiler_;
  std::unique_ptr<driver::Device> device_;
  model::PacketView packet_;
  bool held_ = false;  // packet_ is a line that next() has not given yet
  bool any_ = false;   // a line has come
  bool carried_ = true;
  production::BeltPosition belt_;
  model::PacketHeader header_;
  light_section::Profile profile_;
  model::Runs runs_;
  SourceCounts work_;
  mutable std::mutex mutex_;  // of the two below
  SourceCounts reported_;
  model::Measure newest_;
};

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_LINE_SOURCE_H
