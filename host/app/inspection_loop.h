// The loop of `selfproj inspect`: packets into profiles.
#ifndef SELFPROJ_HOST_APP_INSPECTION_LOOP_H
#define SELFPROJ_HOST_APP_INSPECTION_LOOP_H

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "host/cli/status_line.h"
#include "host/driver/clock.h"
#include "host/driver/counters.h"
#include "host/driver/device.h"
#include "host/light_section/differential_profile.h"
#include "host/light_section/inspection.h"
#include "host/light_section/profile.h"
#include "host/production/part_line.h"
#include "host/rig/rig.h"
#include "model/column_runs.h"
#include "model/packet.h"

namespace selfproj {

// The counters of the inspection itself, beside those of the driver.
struct InspectionWork {
  std::uint64_t profiles = 0;      // frames that became a profile
  std::uint64_t broken = 0;        // frames flagged by the board
  std::uint64_t other_size = 0;    // frames of another size than the rig's camera
  std::uint64_t other_select = 0;  // frames of which the board sent something else than --select
  std::uint64_t not_moments = 0;   // packets of images and codes
  std::uint64_t ambiguous = 0;     // columns whose second run is nearly as strong as the strongest
  std::uint64_t points = 0;        // valid columns of all profiles
  std::int64_t first_ns = 0;       // when the first packet was taken
  std::int64_t first_done_ns = 0;  // when the first profile was there
  std::int64_t last_done_ns = 0;   // and the last one
  DurationHistogram delay;         // from a packet's arrival to its profile

  // Frames per second from the first profile to the last; 0 if there are fewer than two. (Packets of a file arrive many
  // at a time.)
  [[nodiscard]] double rate() const {
    const auto ns = static_cast<double>(last_done_ns - first_done_ns);
    return profiles > 1 && ns > 0 ? static_cast<double>(profiles - 1) * 1e9 / ns : 0;
  }
};

// "12.3 µs" or "1.23 ms".
std::string time_text(std::int64_t ns);

// "delay p50 ..., p99 ..., max ...".
std::string delay_text(const DurationHistogram& delay);

// The counters of the driver that are shown while packets come.
std::string losses_text(const Counters& counters);

// Who takes the profiles, and when it ends.
struct InspectionTarget {
  std::optional<Select> select = {};                  // what the board must have selected; nothing: whatever comes
  std::uint64_t count = 0;                            // profiles; 0: no limit
  double seconds = 0;                                 // after the first packet; 0: no limit
  Inspection* inspection = nullptr;                   // keeps them, if given
  PartLine* line = nullptr;                           // makes parts of them, if given
  std::function<void(const PacketView&)> image = {};  // gets the packets of raw images, if given
  std::function<std::string()> more = {};             // what the line on a terminal says more
  std::function<void(const InspectionWork&, const Counters&)> seen = {};  // called five times a second
};

// Turns packets of a device into profiles, until there are enough, the time is up, or no more come. Ctrl-C ends it
// while a StopSignal exists.
class InspectionLoop {
 public:
  // All arguments must outlive it.
  InspectionLoop(InspectionTarget target, const Rig& rig, const DifferentialProfiler& profiler);

  // Throws UserError if the device sends frames of another rig, and what the line's listeners throw.
  void run(Device& device);

  [[nodiscard]] const InspectionWork& work() const { return work_; }

 private:
  static constexpr std::int64_t kShowNs = 200'000'000;

  std::int64_t take(const PacketView& packet, Device& device);
  bool make_profile(const PacketView& packet, const std::string& uri, const ProfileView& to);
  void show(StatusLine& status, const Device& device, std::int64_t now);

  InspectionTarget target_;
  const Rig& rig_;
  const DifferentialProfiler& profiler_;
  std::uint64_t most_;
  std::int64_t time_ns_;
  Profile profile_;
  InspectionWork work_;
  std::int64_t next_show_ = 0;
  std::uint64_t profiles_shown_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_INSPECTION_LOOP_H
