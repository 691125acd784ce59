#include "host/gentl/line_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "host/camera/camera_device.h"
#include "host/camera/camera_uri.h"
#include "host/driver/clock.h"
#include "host/driver/ring_memory.h"
#include "host/files/user_error.h"
#include "host/gentl/answer.h"
#include "host/light_section/reference.h"
#include "host/light_section/reference_file.h"
#include "model/packet_payload.h"

namespace selfproj::gentl {
namespace {

// The settings of the board in software that the URI of a camera has; none for another device.
CameraBoardSettings board_of(const DeviceEntry& entry) {
  return is_camera_uri(entry.id) && entry.problem.empty() ? parse_camera_uri(entry.uri()).board : CameraBoardSettings{};
}

// The rig, with the pixel clock that the URI of a camera has.
Rig rig_of(const DeviceEntry& entry) {
  Rig rig = load_any_rig(entry.rig);
  if (rig.kind != RigKind::light_section) {
    throw UserError(entry.rig, "is not a rig of kind light-section");
  }
  if (const std::optional<double> clock = board_of(entry).pixel_clock_hz) {
    rig.board = RigBoard{.pixel_clock_hz = *clock};
  }
  return rig;
}

// What is measured before the first frame says it.
Measure measure_of(const DeviceEntry& entry, const Rig& rig) {
  const Measure measure = rig.measure.of_board();
  const CameraBoardSettings board = board_of(entry);
  return {.mode = board.mode.value_or(measure.mode),
          .threshold = board.threshold.value_or(measure.threshold),
          .select = board.select.value_or(measure.select),
          .gap = board.gap.value_or(measure.gap),
          .window = board.window.value_or(measure.window)};
}

ReferenceProfile reference_of(const DeviceEntry& entry, const Rig& rig) {
  return entry.reference.empty() ? reference_of_plane(rig) : load_reference(rig, entry.reference);
}

std::unique_ptr<Device> open_entry(const DeviceEntry& entry, const Rig& rig) {
  if (!entry.problem.empty()) {
    throw GenTLError(GC_ERR_IO, entry.problem);
  }
  for (const RingInfo& ring : list_rings()) {
    if (entry.id != "ring:" + ring.name) {
      continue;
    }
    if (ring.reader) {
      throw GenTLError(GC_ERR_RESOURCE_IN_USE, entry.id + ": another reader has it open");
    }
    if (!ring.problem.empty()) {
      throw UserError(entry.id, ring.problem);
    }
  }
  return open_any_device(entry.uri(), {.wait = Wait::blocking}, camera_of_rig(rig, rig.measure.of_board()));
}

}  // namespace

LineSource::LineSource(const DeviceEntry& entry)
    : rig_(rig_of(entry)),
      profiler_(rig_, reference_of(entry, rig_)),
      device_(open_entry(entry, rig_)),
      belt_(rig_),
      newest_(measure_of(entry, rig_)) {
  profile_.resize(profiler_.columns());
  runs_.resize(Select::strongest, profiler_.columns());
  look(std::chrono::nanoseconds(0));
}

bool LineSource::usable(const PacketView& packet) {
  const PacketHeader& header = packet.header;
  if (header.kind != spec::kKindMoments) {
    ++work_.not_moments;
    return false;
  }
  if (header.columns != rig_.camera.columns || header.rows != rig_.camera.rows) {
    if (!any_) {
      throw UserError(device_->uri(), fmt::format("its frames are {} x {} pixels, those of the rig {} x {}",
                                                  header.columns, header.rows, rig_.camera.columns, rig_.camera.rows));
    }
    ++work_.other_size;
    return false;
  }
  return packet.status == 0;
}

Next LineSource::look(std::chrono::nanoseconds timeout) {
  const std::int64_t until = now_ns() + timeout.count();
  Next found = Next::packet;
  do {
    found = device_->next(packet_, std::chrono::nanoseconds(std::max<std::int64_t>(until - now_ns(), 0)));
    held_ = found == Next::packet && usable(packet_);
  } while (found == Next::packet && !held_ && now_ns() < until);
  any_ = any_ || held_;
  note();
  return held_ ? Next::packet : found == Next::end ? Next::end : Next::timeout;
}

void LineSource::note() {
  const std::lock_guard lock(mutex_);
  reported_ = work_;
  reported_.driver = device_->counters();
  if (held_) {
    newest_ = measure_of(packet_.header);
  }
}

Next LineSource::next(std::chrono::nanoseconds timeout) {
  if (!held_) {
    const Next found = look(timeout);
    if (found != Next::packet) {
      return found;
    }
  }
  compute_line();
  device_->release();
  held_ = false;
  return Next::packet;
}

void LineSource::compute_line() {
  header_ = packet_.header;
  const auto mode = static_cast<Mode>(header_.mode);
  const auto select = static_cast<Select>(header_.select);
  profiler_.profile(select, mode, packet_.payload.data(), profile_.view());
  unpack_columns(select, mode, profiler_.columns(), packet_.payload.data(), runs_.view());
  const double travel = belt_.add(header_);
  if (carried_) {
    for (float& x : profile_.x) {
      x = static_cast<float>(static_cast<double>(x) - travel);
    }
  }
}

void LineSource::begin(bool carried) {
  carried_ = carried;
  belt_ = BeltPosition(rig_);
}

SourceCounts LineSource::counts() const {
  const std::lock_guard lock(mutex_);
  return reported_;
}

Measure LineSource::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

}  // namespace selfproj::gentl
