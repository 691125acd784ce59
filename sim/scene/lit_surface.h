// The surface of a scene between camera and projector: what a pixel's ray meets, and how much of the projector's light
// falls there.
#ifndef SELFPROJ_SIM_SCENE_LIT_SURFACE_H
#define SELFPROJ_SIM_SCENE_LIT_SURFACE_H

#include "host/rig/rig.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/scene.h"

namespace selfproj {

class LitSurface {
 public:
  struct Hit {
    Point3 point;
    double height;
    bool level;  // so is all of the surface around
  };

  // The scene must live as long. `falloff`: light falls with the distance from the projector, squared, and is as stated
  // on the plane at x = y = 0.
  LitSurface(const Rig& rig, const Scene& scene, bool falloff);

  // Bounds of all heights from t0 to t1.
  [[nodiscard]] HeightRange all_heights(double t0, double t1) const;

  // Bounds of the heights that the rays through a rectangle of the image can meet from t0 to t1; `all` bounds all.
  [[nodiscard]] HeightRange heights_between(PixelPoint first, PixelPoint last, double t0, double t1,
                                            HeightRange all) const;

  // What the ray of a pixel meets first, at the time t, where the surface is known to lie between these heights.
  [[nodiscard]] Hit hit(PixelPoint pixel, double t, HeightRange heights) const;

  // Of the surface there, of length 1, towards the camera.
  [[nodiscard]] Point3 normal(const Hit& hit, double t) const;

  // The cosine of the incidence of the projector's light on a point of such a normal, with falloff where that is
  // wanted; 0 where it is turned away.
  [[nodiscard]] double incidence(Point3 point, Point3 normal) const;

  // Whether the surface keeps the light from a point. `highest`: bound of all heights.
  [[nodiscard]] bool in_shadow(Point3 point, Point3 normal, double t, double highest) const;

  // Incidence, 0 in the shadow.
  [[nodiscard]] double lit_share(const Hit& hit, double t, double highest) const;

 private:
  const Scene& scene_;
  double plane_z_;
  bool falloff_;
  Pinhole camera_;
  Point3 projector_;  // its centre
};

// mm off a surface, where its shadow is looked for.
inline constexpr double kShadowLift = 1e-3;

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_LIT_SURFACE_H
