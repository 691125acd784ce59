// A part that lies elsewhere than it should: higher, aside, turned.
#ifndef SELFPROJ_SIM_SCENE_MOVED_SCENE_H
#define SELFPROJ_SIM_SCENE_MOVED_SCENE_H

#include <string>

#include "sim/scene/scene.h"

namespace selfproj::sim {

// First turned about the vertical through the part's middle, then moved.
struct Displacement {
  double lift_mm = 0;   // away from the plane; the plane stays where it is
  double aside_mm = 0;  // along +y
  double turn_deg = 0;

  [[nodiscard]] bool any() const { return lift_mm != 0 || aside_mm != 0 || turn_deg != 0; }
};

// A part of a conveyed scene, so displaced. Whatever is higher than the plane is the part, so a part must be higher
// than it everywhere.
class MovedScene final : public WrappedScene {
 public:
  // Throws UserError about `options` if the scene is none of a part on a conveyor.
  MovedScene(const Scene& scene, const Displacement& displacement, const std::string& options);

  [[nodiscard]] double height(double x, double y, double t) const override;
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override;
  [[nodiscard]] double albedo(double x, double y, double t) const override;
  [[nodiscard]] Smoothness smoothness(const Box& /*box*/) const override { return {}; }
  [[nodiscard]] bool is_plain(const Box& /*box*/) const override { return even_albedo(); }

 private:
  // The place of the part that lies at (x, y) when its middle is at (middle, 0).
  struct Place {
    double x, y;
  };
  [[nodiscard]] Place place(double x, double y, double middle) const;
  [[nodiscard]] Box box_of(const Box& box, double middle) const;
  [[nodiscard]] double lifted(double height) const { return height > 0 ? height + lift_ : height; }

  const ConveyedScene& part_;
  double lift_, aside_;
  double cos_, sin_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_MOVED_SCENE_H
