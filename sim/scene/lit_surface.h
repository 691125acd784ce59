// The surface of a scene between camera and projector: what a pixel's ray meets, and how much of the projector's light
// falls there.
#ifndef SELFPROJ_SIM_SCENE_LIT_SURFACE_H
#define SELFPROJ_SIM_SCENE_LIT_SURFACE_H

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "sim/scene/pinhole.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/sight_table.h"
#include "sim/scene/world.h"

namespace selfproj {

// Bounds of x and y of these sights and of all sights between them. The sights of the corners of a rectangle of the
// image (Pinhole::corner_sights) give the bounds of the rectangle.
Box tangents_of(std::span<const Point3> sights);

class LitSurface {
 public:
  struct Hit {
    Point3 point;
    double height;
    bool level;  // the surface is level here and all around
  };

  // The scene must live as long as this object. With `falloff` the light decreases with the square of the distance from
  // the projector, and is as stated on the plane at x = y = 0. Of the world only gloss and texture matter.
  LitSurface(const RealRig& real, const Scene& scene, bool falloff, const World& world = {});

  // Bounds of all heights from t0 to t1.
  [[nodiscard]] HeightRange all_heights(double t0, double t1) const;

  // Bounds of the heights that the rays through a rectangle of the image can meet from t0 to t1. `all` bounds all
  // heights, and `tangents` x and y of the sights of these rays.
  [[nodiscard]] HeightRange heights_between(PixelPoint first, PixelPoint last, double t0, double t1,
                                            HeightRange all) const {
    return heights_between(tangents_of(camera_.corner_sights(first, last)), t0, t1, all);
  }
  [[nodiscard]] HeightRange heights_between(const Box& tangents, double t0, double t1, HeightRange all) const;

  // If the surface that rays between these bounds of sights meet from t0 to t1 is level, and is level for some way
  // around, too: its height. Otherwise `heights`, which bound what the rays meet. A ray that is traced may end above or
  // below the returned height by up to the tolerance of heights.
  [[nodiscard]] HeightRange plateau(const Box& tangents, double t0, double t1, HeightRange heights) const;

  // Bounds of the places at which those rays meet heights in this range.
  [[nodiscard]] Box footprint(PixelPoint first, PixelPoint last, HeightRange heights) const;

  // How smooth the surface is there; nothing is known of it unless it scatters evenly and has one albedo.
  [[nodiscard]] Smoothness smoothness(const Box& box) const {
    return gloss_ || texture_ || !scene_.is_plain(box) ? Smoothness{} : scene_.smoothness(box);
  }

  // Whether none, some or all of the points that the rays of a rectangle of the image meet at one height are in the
  // shadow from t0 to t1. `some` also stands for cases that the bounds do not decide. `highest` bounds all heights.
  enum class Shadow : std::uint8_t { none, some, all };
  [[nodiscard]] Shadow shadow_on_level(const Box& tangents, double height, double t0, double t1, double highest) const;

  // Whether the way from the point to the projector is so steep that no part of the surface can cross it.
  [[nodiscard]] bool is_above_all(Point3 point) const;

  // The first point that the ray of a pixel meets at the time t, if the surface is known to lie between these heights.
  [[nodiscard]] Hit hit(PixelPoint pixel, double t, HeightRange heights) const {
    return hit_along(sight(pixel), t, heights);
  }
  [[nodiscard]] Hit hit_along(Point3 sight, double t, HeightRange heights) const;

  // Pinhole::sight of the camera.
  [[nodiscard]] Point3 sight(PixelPoint pixel) const { return sights_ ? sights_->sight(pixel) : camera_.sight(pixel); }

  // The normal of the surface there, of length 1, towards the camera.
  [[nodiscard]] Point3 normal(const Hit& hit, double t) const;

  // The cosine of the incidence of the projector's light on a point with this normal, including the falloff if it is
  // on; 0 if the point faces away.
  [[nodiscard]] double incidence(Point3 point, Point3 normal) const;

  // Whether the surface blocks the light to a point. `highest` bounds all heights.
  [[nodiscard]] bool in_shadow(Point3 point, Point3 normal, double t, double highest) const;

  // The albedo of the surface there, with its texture; and whether it is the same everywhere at all times.
  [[nodiscard]] double albedo(Point3 point, double t) const;
  [[nodiscard]] bool even_albedo() const { return scene_.even_albedo() && !texture_; }

  // The share of the irradiance that goes towards the camera, relative to that of a white surface that scatters evenly:
  // the albedo, unless the surface shines.
  [[nodiscard]] double reflectance(const Hit& hit, double t) const {
    const double even = albedo(hit.point, t);
    return gloss_ ? reflectance(hit.point, normal(hit, t), even) : even;
  }
  [[nodiscard]] double reflectance(Point3 point, Point3 normal, double albedo) const;

  // The incidence, or 0 in the shadow.
  [[nodiscard]] double lit_share(const Hit& hit, double t, double highest) const;

 private:
  // Where sights of these tangents meet heights in this range.
  [[nodiscard]] Box between(const Box& tangents, HeightRange heights) const;

  // The straight ways of light from a rectangle at the height `from` to the projector.
  struct Beam {
    Box start;
    double from;
    double t0, t1;
  };
  [[nodiscard]] Shadow shadow_in(const Beam& beam, HeightRange segment, int halvings) const;

  const Scene& scene_;
  double plane_z_;
  bool falloff_;
  Pinhole camera_;
  std::shared_ptr<const SightTable> sights_;  // null: the camera itself is as fast
  Point3 projector_;                          // centre of the projector
  double steepest_;                           // slope of the surface
  std::optional<Gloss> gloss_;
  std::optional<TextureField> texture_;
};

// mm above a surface at which the test for its shadow begins.
inline constexpr double kShadowLift = 1e-3;

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_LIT_SURFACE_H
