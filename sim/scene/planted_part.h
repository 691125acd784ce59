// A part with two treads on a conveyor, as it happens to lie, with defects planted into its surface.
#ifndef SELFPROJ_SIM_SCENE_PLANTED_PART_H
#define SELFPROJ_SIM_SCENE_PLANTED_PART_H

#include <array>
#include <cstddef>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/scene.h"

namespace selfproj::sim {

// A round place with a flat bottom and a vertical wall, mm: a dent, or, with a negative depth, a bump.
struct PlantedDefect {
  std::size_t tread = 0;  // 0: left, 1: right; the defect lies on it as a whole
  double along = 0;       // of its middle, from the leading edge against the way of the belt
  double across = 0;      // from the middle of the part
  double size = 0;        // diameter
  double depth = 0;
};

// How a part lies: shifted along the belt and across, and turned about its middle.
struct PartPose {
  double along_mm = 0;  // with the belt
  double across_mm = 0;
  double turn_deg = 0;
};

class PlantedPart : public ConveyedScene {
 public:
  static constexpr double kLength = 16;  // along the belt
  static constexpr double kTreadWidth = 22;
  static constexpr std::array<double, 2> kTreads = {12, 20};  // heights

  PlantedPart(const rig::Rig& rig, const PartPose& pose, std::vector<PlantedDefect> defects);

  [[nodiscard]] double part_height(double x, double y) const override;
  [[nodiscard]] HeightRange part_range(const Box& box) const override;

 private:
  [[nodiscard]] static double tread_height(double w) { return w < 0 ? kTreads[0] : kTreads[1]; }

  PartPose pose_;
  double cos_, sin_;
  std::vector<PlantedDefect> defects_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_PLANTED_PART_H
