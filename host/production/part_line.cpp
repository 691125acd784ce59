#include "host/production/part_line.h"

#include <chrono>
#include <cstdint>
#include <thread>
#include <utility>

namespace selfproj {
namespace {

constexpr auto kNapWhenFull = std::chrono::microseconds(100);

}  // namespace

PartLine::PartLine(const Rig& rig, const Judge* judge, Listeners listeners)
    : LineWorker(rig, judge, std::move(listeners.part)),
      profile_(std::move(listeners.profile)),
      queue_(kQueued, [&](Profile& profile) { profile.resize(rig.camera.columns); }) {
  if (judges()) {
    cutter_.emplace(rig, [this](CutPart&& part) { take(std::move(part)); });
  }
  start(64);
}

ProfileView PartLine::claim() {
  auto* slot = queue_.claim();
  for (check(); slot == nullptr; check()) {
    std::this_thread::sleep_for(kNapWhenFull);
    slot = queue_.claim();
  }
  return slot->thing.view();
}

void PartLine::publish(const PacketHeader& header, std::int64_t arrival_ns) {
  auto* const slot = queue_.claim();  // that of the last claim()
  slot->header = header;
  slot->arrival_ns = arrival_ns;
  queue_.publish();
}

bool PartLine::work() {
  auto* const slot = queue_.front();
  if (slot == nullptr) {
    return false;
  }
  const ProfileView profile = slot->thing.view();
  if (cutter_) {
    cutter_->add(slot->header, profile, slot->arrival_ns);
  }
  if (profile_) {
    profile_(slot->header, profile);
  }
  arrived(slot->arrival_ns);
  queue_.release();
  return true;
}

}  // namespace selfproj
