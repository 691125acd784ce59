#include "host/gentl/line_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "host/camera/camera_device.h"
#include "host/camera/camera_uri.h"
#include "host/driver/clock.h"
#include "host/driver/ring_memory.h"
#include "host/gentl/answer.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/packet_payload.h"

namespace selfproj::gentl {
namespace {

// The settings of the board in software that the URI of a camera has; none for another device.
camera::CameraBoardSettings board_of(const DeviceEntry& entry) {
  return camera::is_camera_uri(entry.id) && entry.problem.empty() ? camera::parse_camera_uri(entry.uri()).board
                                                                  : camera::CameraBoardSettings{};
}

// The rig, with the pixel clock that the URI of a camera has.
rig::Rig rig_of(const DeviceEntry& entry) {
  rig::Rig rig = rig::load_any_rig(entry.rig);
  if (rig.kind != rig::RigKind::light_section) {
    throw UserError(entry.rig, "is not a rig of kind light-section");
  }
  rig::expect_measured(rig, entry.rig);
  if (const std::optional<double> clock = board_of(entry).pixel_clock_hz) {
    rig.board = rig::RigBoard{.pixel_clock_hz = *clock};
  }
  return rig;
}

// What is measured before the first frame says it.
model::Measure measure_of(const DeviceEntry& entry, const rig::Rig& rig) {
  const model::Measure measure = rig.measure.of_board();
  const camera::CameraBoardSettings board = board_of(entry);
  return {.mode = board.mode.value_or(measure.mode),
          .threshold = board.threshold.value_or(measure.threshold),
          .select = board.select.value_or(measure.select),
          .gap = board.gap.value_or(measure.gap),
          .window = board.window.value_or(measure.window),
          .bits = measure.bits};
}

light_section::ReferenceProfile reference_of(const DeviceEntry& entry, const rig::Rig& rig) {
  return entry.reference.empty() ? light_section::reference_of_plane(rig)
                                 : light_section::load_reference(rig, entry.reference);
}

std::unique_ptr<driver::Device> open_entry(const DeviceEntry& entry, const rig::Rig& rig) {
  if (!entry.problem.empty()) {
    throw GenTLError(GC_ERR_IO, entry.problem);
  }
  for (const driver::RingInfo& ring : driver::list_rings()) {
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
  return camera::open_any_device(entry.uri(), {.wait = driver::Wait::blocking},
                                 camera::camera_of_rig(rig, rig.measure.of_board()));
}

}  // namespace

LineSource::LineSource(const DeviceEntry& entry)
    : rig_(rig_of(entry)),
      profiler_(rig_, reference_of(entry, rig_)),
      device_(open_entry(entry, rig_)),
      belt_(rig_),
      newest_(measure_of(entry, rig_)) {
  profile_.resize(profiler_.columns());
  runs_.resize(model::Select::strongest, profiler_.columns());
  look(std::chrono::nanoseconds(0));
}

bool LineSource::usable(const model::PacketView& packet) {
  const model::PacketHeader& header = packet.header;
  if (!model::has_columns(header.kind)) {
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
  if (const int bits = rig_.measure.bits(); header.pixel_bits != bits) {
    if (!any_) {
      throw UserError(device_->uri(), fmt::format("its pixels have {} bits; measure.pixel_bits of the rig is {}",
                                                  header.pixel_bits, bits));
    }
    ++work_.other_size;
    return false;
  }
  if (const std::string unlike = profiler_.unlike_reference(header); !any_ && !unlike.empty()) {
    throw UserError(device_->uri(), unlike);
  }
  return packet.status == 0;
}

driver::Next LineSource::look(std::chrono::nanoseconds timeout) {
  const std::int64_t until = driver::now_ns() + timeout.count();
  driver::Next found = driver::Next::packet;
  do {
    found = device_->next(packet_, std::chrono::nanoseconds(std::max<std::int64_t>(until - driver::now_ns(), 0)));
    held_ = found == driver::Next::packet && usable(packet_);
  } while (found == driver::Next::packet && !held_ && driver::now_ns() < until);
  any_ = any_ || held_;
  note();
  return held_ ? driver::Next::packet : found == driver::Next::end ? driver::Next::end : driver::Next::timeout;
}

void LineSource::note() {
  const std::lock_guard lock(mutex_);
  reported_ = work_;
  reported_.driver = device_->counters();
  if (held_) {
    newest_ = model::measure_of(packet_.header);
  }
}

driver::Next LineSource::next(std::chrono::nanoseconds timeout) {
  if (!held_) {
    const driver::Next found = look(timeout);
    if (found != driver::Next::packet) {
      return found;
    }
  }
  compute_line();
  device_->release();
  held_ = false;
  return driver::Next::packet;
}

void LineSource::compute_line() {
  header_ = packet_.header;
  profiler_.profile(model::column_word(header_), packet_.payload.data(), profile_.view());
  model::unpack_columns(header_, packet_.payload.data(), runs_.view());
  const double travel = belt_.add(header_);
  if (carried_) {
    for (float& x : profile_.x) {
      x = static_cast<float>(static_cast<double>(x) - travel);
    }
  }
}

void LineSource::begin(bool carried) {
  carried_ = carried;
  belt_ = production::BeltPosition(rig_);
}

SourceCounts LineSource::counts() const {
  const std::lock_guard lock(mutex_);
  return reported_;
}

model::Measure LineSource::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

}  // namespace selfproj::gentl
