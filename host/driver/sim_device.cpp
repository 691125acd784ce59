#include "host/driver/sim_device.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "host/driver/clock.h"

namespace selfproj::driver {

SimDevice::SimDevice(std::size_t buffer_bytes) : TalliedDevice("sim:", {}), reader_(counters_, buffer_bytes) {}

bool SimDevice::push(std::span<const std::uint8_t> bytes, bool last) {
  std::span<std::uint8_t> room = reader_.room_in_place();
  if (room.size() < bytes.size() && !held_) {
    room = reader_.room();
  }
  if (room.size() < bytes.size()) {
    return false;
  }
  std::copy(bytes.begin(), bytes.end(), room.begin());
  reader_.added(bytes.size());
  since_last_ += bytes.size();
  if (last) {
    arrival_ns_ = now_ns();
    const bool whole =
        since_last_ <= reader_.held() && model::announced_packet_bytes(reader_.newest(since_last_)) == since_last_;
    misframed_ += whole ? 0 : 1;
    since_last_ = 0;
  }
  return true;
}

void SimDevice::finish() {
  finished_ = true;
  misframed_ += since_last_ != 0 ? 1 : 0;
  since_last_ = 0;
  reader_.finish();
}

Next SimDevice::next(model::PacketView& packet, std::chrono::nanoseconds /*timeout*/) {
  held_ = false;
  while (reader_.next(packet)) {
    if (tally_.deliver(packet)) {
      held_ = true;
      return Next::packet;
    }
  }
  return finished_ ? Next::end : Next::timeout;
}

}  // namespace selfproj::driver
