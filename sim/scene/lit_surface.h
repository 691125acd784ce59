// The surface of a scene between camera and projector: what a ray meets, how much of the projector's light falls there,
// and how much of it goes on to the camera and to other faces.
#ifndef SELFPROJ_SIM_SCENE_LIT_SURFACE_H
#define SELFPROJ_SIM_SCENE_LIT_SURFACE_H

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/scene/optics.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "sim/scene/world.h"

namespace selfproj::sim {

// Where rays meet the surface of a scene is found from the bounds alone that it gives of its heights: exact for smooth
// slopes and vertical faces, without stepping along the ray.

// A straight line, given by its place at each height h above the plane: (x + dx h, y + dy h).
struct HeightRay {
  double x, dx;
  double y, dy;
};

// The tolerance of heights, mm.
constexpr double kHeightTolerance = 1e-4;

// The greatest height in low..high, mm, at which the ray, coming from above, is at or below the surface at the time t;
// `low` if there is none. Never below the surface's least height along the ray, if that is at least `low`.
double first_hit(const Scene& scene, const HeightRay& ray, double t, double low, double high);

// Whether the surface rises above the ray anywhere between the heights low and high.
bool is_blocked(const Scene& scene, const HeightRay& ray, double t, double low, double high);

// The share of the facets' area whose normal has this cosine to the surface's, per steradian (Beckmann):
// D = exp(-tan² / m²) / (π m² cos⁴). The integral of D cos over the half space is 1.
double facets(double cosine, double roughness);

// The light towards the camera, relative to that of a white surface that scatters evenly, under the same irradiance:
// albedo · diffuse + π D F G / (4 (n·l) (n·v)), with Schlick's F and the G of Cook and Torrance (1982). All directions
// have length 1. 0 unless light and camera are above the surface.
double relative_radiance(const Gloss& gloss, double albedo, Point3 normal, Point3 to_light, Point3 to_camera);

// A sum of waves of one period in even directions: of mean 1, variance contrast², and with the autocorrelation
// J0(2π r / scale) of an isotropic sum, but for the finite number of waves.
class TextureField {
 public:
  TextureField(const Texture& texture, std::uint64_t seed);

  // The factor of the albedo at a place of the surface, mm; at least 0.05.
  [[nodiscard]] double at(double x, double y) const;

 private:
  struct Wave {
    double along_x, along_y, phase;
  };
  static constexpr int kWaves = 12;
  double amplitude_;
  std::array<Wave, kWaves> waves_{};
};

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
  LitSurface(const PerturbedRig& actual, const Scene& scene, bool falloff, const World& world = {});

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

// One bounce of light: lit faces throw light onto others.

// The light is taken patch by patch of the projector, and received every 4 pixels of the camera, linear in between. A
// patch of area A and albedo ρ under irradiance E lights a point at the distance d with ρ E cos cos' A / (π d² + A).
// Faces in the way do not block it, and bodies take no part.
class BounceLight {
 public:
  // The scene must live as long as this; `surface` is what camera and projector see of it.
  BounceLight(const PerturbedRig& actual, const Scene& scene, const LitSurface& surface, const Bounce& bounce);

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

  PerturbedRig actual_;
  const Scene& scene_;
  const LitSurface& surface_;
  double strength_;
  int down_, across_;                // receivers
  std::vector<Receiver> receivers_;  // of a scene that stands still
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_LIT_SURFACE_H
