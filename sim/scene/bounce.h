// One bounce of light: lit faces throw light onto others.
#ifndef SELFPROJ_SIM_SCENE_BOUNCE_H
#define SELFPROJ_SIM_SCENE_BOUNCE_H

#include <span>
#include <vector>

#include "sim/scene/bounce_strength.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/scene.h"

namespace selfproj {

// The light is taken patch by patch of the projector, and received every 4 pixels of the camera, linear in between. A
// patch of area A and albedo ρ under irradiance E lights a point at the distance d with ρ E cos cos' A / (π d² + A).
// Faces in the way do not block it, and bodies take no part.
class BounceLight {
 public:
  // The scene must live as long as this; `surface` is what camera and projector see of it.
  BounceLight(const RealRig& real, const Scene& scene, const LitSurface& surface, const Bounce& bounce);

  // Adds the grey values of this light at the time t under a pattern.
  void add(const ProjectedLight& pattern, double t, std::span<float> pixels) const;

  // The irradiance that a point with this normal receives from other faces at the time t, in units of the projector's
  // full light at normal incidence.
  [[nodiscard]] double irradiance(const ProjectedLight& pattern, double t, Point3 point, Point3 normal) const;

  // Pixels from one receiver to the next.
  static constexpr int kStep = 4;

 private:
  struct Source {
    Point3 point;
    Point3 normal;
    double flux;  // albedo times irradiance times area, mm²
    double area;  // mm²
  };
  struct Receiver {
    Point3 point;
    Point3 normal;
    double grey;  // grey values for an irradiance of 1
  };

  [[nodiscard]] std::vector<Source> sources(const ProjectedLight& pattern, double t) const;
  [[nodiscard]] std::vector<Receiver> receivers(double t) const;
  static double received(const std::vector<Source>& sources, Point3 point, Point3 normal);

  RealRig real_;
  const Scene& scene_;
  const LitSurface& surface_;
  double strength_;
  int down_, across_;                // receivers
  std::vector<Receiver> receivers_;  // of a scene that stands still
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BOUNCE_H
