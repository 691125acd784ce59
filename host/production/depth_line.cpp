#include "host/production/depth_line.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>
#include <utility>

namespace selfproj {
namespace {

constexpr auto kNapWhenFull = std::chrono::microseconds(100);

}  // namespace

DepthLine::DepthLine(const Rig& rig, int patterns, const Judge* judge, Listeners listeners)
    : LineWorker(rig, judge, std::move(listeners.part)),
      image_(std::move(listeners.image)),
      queue_(kQueued,
             [&](Maps& maps) { maps.depth = maps.difference = FloatImage(rig.camera.rows, rig.camera.columns); }) {
  if (judges()) {
    cutter_.emplace(rig, patterns, [this](CutPart&& part) { take(std::move(part)); });
  }
  start(1);
}

void DepthLine::add(const PacketHeader& header, std::int64_t arrival_ns, const FloatImage& depth,
                    const FloatImage& difference) {
  auto* slot = queue_.claim();
  for (check(); slot == nullptr; check()) {
    std::this_thread::sleep_for(kNapWhenFull);
    slot = queue_.claim();
  }
  slot->header = header;
  slot->arrival_ns = arrival_ns;
  std::copy(depth.values.begin(), depth.values.end(), slot->thing.depth.values.begin());
  std::copy(difference.values.begin(), difference.values.end(), slot->thing.difference.values.begin());
  queue_.publish();
}

bool DepthLine::work() {
  auto* const slot = queue_.front();
  if (slot == nullptr) {
    return false;
  }
  if (cutter_) {
    cutter_->add(slot->header, slot->thing.depth, slot->arrival_ns);
  }
  if (image_) {
    image_(slot->header, slot->thing);
  }
  arrived(slot->arrival_ns);
  queue_.release();
  return true;
}

}  // namespace selfproj
