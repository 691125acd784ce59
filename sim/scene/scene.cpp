#include "sim/scene/scene.h"

#include <algorithm>
#include <cmath>

#include "host/rig/rig.h"

namespace selfproj {
namespace {

int frames_of(const Rig& rig, double length) {
  const double step = rig.conveyor.speed_mm_per_s / rig.camera.frame_rate_hz;
  constexpr double kMost = 1e6;
  return step > 0 ? static_cast<int>(std::clamp(std::round((length + 2 * ConveyedScene::kLead) / step), 1.0, kMost))
                  : 1;
}

}  // namespace

ConveyedScene::ConveyedScene(const Rig& rig, double length)
    : speed_(rig.conveyor.speed_mm_per_s),
      start_(speed_ > 0 ? -(length / 2 + kLead) : 0),
      frames_(frames_of(rig, length)) {}

}  // namespace selfproj
