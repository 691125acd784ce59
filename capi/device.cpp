// Devices.
#include "selfproj/driver/device.h"

#include <chrono>
#include <cstdint>
#include <memory>

#include "capi/convert.h"

struct selfproj_device {  // NOLINT(readability-identifier-naming): a name of C
  std::unique_ptr<selfproj::driver::Device> device;
};

namespace selfproj::capi {
namespace {

constexpr std::int64_t kMaxTimeout = 1'000'000'000'000'000'000;
constexpr std::uint32_t kOldestOptions = 16;
constexpr std::uint32_t kOldestCounters = 160;
static_assert(sizeof(selfproj_device_options) == kOldestOptions);
static_assert(sizeof(selfproj_counters) == kOldestCounters);
static_assert(sizeof(driver::Counters) == kOldestCounters - 8, "a counter is missing here");

driver::Wait wait_of(std::int32_t wait) {
  require(wait >= SELFPROJ_WAIT_POLL_THEN_BLOCK && wait <= SELFPROJ_WAIT_BLOCK, "options: unknown way to wait");
  return wait == SELFPROJ_WAIT_POLL    ? driver::Wait::polling
         : wait == SELFPROJ_WAIT_BLOCK ? driver::Wait::blocking
                                       : driver::Wait::polling_then_blocking;
}

driver::DeviceOptions options_of(const selfproj_device_options* options) {
  driver::DeviceOptions out;
  if (options != nullptr) {
    const selfproj_device_options from = copy_of(options, kOldestOptions, "options: size is not set");
    out.wait = wait_of(from.wait);
    out.wait_for_board = from.wait_for_board != 0;
    out.discard_backlog = from.discard_backlog != 0;
  }
  return out;
}

}  // namespace
}  // namespace selfproj::capi

using namespace selfproj;
using namespace selfproj::capi;

std::int32_t selfproj_device_open(const char* uri, const selfproj_device_options* options, selfproj_device** out) {
  return guarded([&] {
    require(uri != nullptr && out != nullptr, "null pointer");
    *out = new selfproj_device{driver::open_device(uri, options_of(options))};
  });
}

void selfproj_device_close(selfproj_device* device) { delete device; }

std::int32_t selfproj_device_next(selfproj_device* device, std::int64_t timeout_ns, selfproj_packet* packet) {
  return guarded([&] {
    require(device != nullptr, "null pointer");
    require(timeout_ns >= 0 && timeout_ns <= kMaxTimeout, "timeout_ns is not in 0..10^18");
    check_packet(packet);
    model::PacketView view;
    switch (device->device->next(view, std::chrono::nanoseconds(timeout_ns))) {
      case driver::Next::packet:
        write_packet(view, packet);
        return SELFPROJ_OK;
      case driver::Next::timeout:
        return SELFPROJ_TIMEOUT;
      case driver::Next::end:
        break;
    }
    return SELFPROJ_END;
  });
}

std::int32_t selfproj_device_release(selfproj_device* device) {
  return guarded([&] {
    require(device != nullptr, "null pointer");
    device->device->release();
  });
}

std::int32_t selfproj_device_counters(const selfproj_device* device, selfproj_counters* counters) {
  return guarded([&] {
    require(device != nullptr, "null pointer");
    require(counters != nullptr && counters->size >= kOldestCounters, "counters: null pointer, or size is not set");
    const driver::Counters from = device->device->counters();
    selfproj_counters value{};
    value.delivered = from.delivered;
    value.flagged = from.flagged;
    value.lost_board = from.lost_board;
    value.lost_ring = from.lost_ring;
    value.missing = from.missing;
    value.bad = from.bad;
    value.other_spec = from.other_spec;
    value.resynchronized = from.resynchronized;
    value.bytes_discarded = from.bytes_discarded;
    value.repeated = from.repeated;
    value.restarts = from.restarts;
    value.reattached = from.reattached;
    value.read_errors = from.read_errors;
    value.lost_network = from.lost_network;
    value.datagrams_lost = from.datagrams_lost;
    value.datagrams_overflow = from.datagrams_overflow;
    value.datagrams_doubled = from.datagrams_doubled;
    value.datagrams_reordered = from.datagrams_reordered;
    value.datagrams_refused = from.datagrams_refused;
    copy_to(value, counters);
  });
}
