#include "host/app/inspection_loop.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "host/cli/status_line.h"
#include "host/driver/clock.h"
#include "host/driver/counters.h"
#include "host/files/stop_signal.h"
#include "host/files/user_error.h"
#include "host/images/frame_options.h"
#include "model/packet.h"

namespace selfproj {

std::string time_text(std::int64_t ns) {
  const auto value = static_cast<double>(ns);
  return ns < 1'000'000 ? fmt::format("{:.1f} µs", value * 1e-3) : fmt::format("{:.2f} ms", value * 1e-6);
}

std::string delay_text(const DurationHistogram& delay) {
  return fmt::format("delay p50 {}, p99 {}, max {}", time_text(delay.percentile_ns(0.5)),
                     time_text(delay.percentile_ns(0.99)), time_text(delay.longest_ns()));
}

std::string losses_text(const Counters& counters) {
  return counters_text(counters, {&Counters::lost_board, &Counters::lost_ring, &Counters::lost_network,
                                  &Counters::missing, &Counters::bad});
}

InspectionLoop::InspectionLoop(InspectionTarget target, const Rig& rig, const DifferentialProfiler& profiler)
    : target_(std::move(target)),
      rig_(rig),
      profiler_(profiler),
      most_(target_.count > 0 ? target_.count : std::numeric_limits<std::uint64_t>::max()),
      time_ns_(target_.seconds > 0 ? static_cast<std::int64_t>(target_.seconds * 1e9)
                                   : std::numeric_limits<std::int64_t>::max()) {
  profile_.resize(profiler.columns());
}

void InspectionLoop::run(Device& device) {
  constexpr auto kPatience = std::chrono::milliseconds(50);  // so that Ctrl-C and the end of the time are noticed
  StatusLine status;
  next_show_ = now_ns() + kShowNs;
  PacketView packet;
  for (Next next = Next::timeout; next != Next::end && work_.profiles < most_ && !StopSignal::came();) {
    next = device.next(packet, kPatience);
    const std::int64_t now = next == Next::packet ? take(packet, device) : now_ns();
    if (work_.first_ns != 0 && now - work_.first_ns >= time_ns_) {
      break;
    }
    if (now >= next_show_) {
      show(status, device, now);
    }
  }
  status.show("");
}

// Takes the packet and returns it to the device. Returns the time when that was done.
std::int64_t InspectionLoop::take(const PacketView& packet, Device& device) {
  work_.first_ns = work_.first_ns == 0 ? now_ns() : work_.first_ns;  // a backlog came in long before
  const ProfileView to = target_.line != nullptr ? target_.line->claim() : profile_.view();
  const bool made = make_profile(packet, device.uri(), to);
  const std::int64_t now = now_ns();
  if (made) {
    work_.first_done_ns = work_.profiles == 0 ? now : work_.first_done_ns;
    work_.last_done_ns = now;
    work_.delay.add(now - device.arrival_ns());
    ++work_.profiles;
    std::uint32_t points = 0;
    std::uint32_t ambiguous = 0;
    for (int i = 0; i < profiler_.columns(); ++i) {
      points += to.validity[i] == static_cast<std::uint8_t>(Validity::valid) ? 1U : 0U;
      ambiguous += to.validity[i] == static_cast<std::uint8_t>(Validity::ambiguous) ? 1U : 0U;
    }
    work_.points += points;
    work_.ambiguous += ambiguous;
    if (target_.inspection != nullptr) {
      target_.inspection->add(packet.header, packet.payload, to);
    }
    if (target_.line != nullptr) {
      target_.line->publish(packet.header, device.arrival_ns());
    }
  }
  device.release();
  return now;
}

// Computes the packet's profile. Returns false if it gives none.
bool InspectionLoop::make_profile(const PacketView& packet, const std::string& uri, const ProfileView& to) {
  const PacketHeader& header = packet.header;
  if (header.kind != spec::kKindMoments) {
    ++work_.not_moments;
    if (target_.image) {
      target_.image(packet);
    }
    return false;
  }
  if (header.columns != rig_.camera.columns || header.rows != rig_.camera.rows) {
    if (work_.profiles == 0) {
      throw UserError(uri, fmt::format("its frames are {} x {} pixels, those of the rig {} x {}", header.columns,
                                       header.rows, rig_.camera.columns, rig_.camera.rows));
    }
    ++work_.other_size;
    return false;
  }
  if (packet.status != 0) {
    ++work_.broken;
    return false;
  }
  if (target_.select && header.select != static_cast<std::uint8_t>(*target_.select)) {
    if (work_.profiles == 0) {
      throw UserError(uri, fmt::format("its packets tell of {}, not of --select {}",
                                       select_name(static_cast<Select>(header.select)), select_name(*target_.select)));
    }
    ++work_.other_select;
    return false;
  }
  profiler_.profile(static_cast<Select>(header.select), static_cast<Mode>(header.mode), packet.payload.data(), to);
  return true;
}

void InspectionLoop::show(StatusLine& status, const Device& device, std::int64_t now) {
  if (status.visible()) {
    const double rate =
        static_cast<double>(work_.profiles - profiles_shown_) * 1e9 / static_cast<double>(now - next_show_ + kShowNs);
    status.show(fmt::format("{} frames, {:.0f}/s, {}, {}{}", work_.profiles, rate, losses_text(device.counters()),
                            delay_text(work_.delay), target_.more ? target_.more() : std::string()));
  }
  if (target_.seen) {
    target_.seen(work_, device.counters());
  }
  profiles_shown_ = work_.profiles;
  next_show_ = now + kShowNs;
}

}  // namespace selfproj
