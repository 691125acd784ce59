#include "sim/scene/lit_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/scene/ray.h"

namespace selfproj {
namespace {

constexpr double kSlopeStep = 5e-3;  // mm to either side, for the slope of the surface
constexpr double kEverywhere = 1e6;  // mm

}  // namespace

Box tangents_of(std::span<const Point3> sights) {
  Box box{sights[0].x, sights[0].x, sights[0].y, sights[0].y};
  for (const Point3 sight : sights) {
    box = {std::min(box.x0, sight.x), std::max(box.x1, sight.x), std::min(box.y0, sight.y), std::max(box.y1, sight.y)};
  }
  return box;
}

LitSurface::LitSurface(const RealRig& real, const Scene& scene, bool falloff, const World& world)
    : scene_(scene),
      plane_z_(real.rig.plane_z_mm),
      falloff_(falloff),
      camera_(real.camera),
      sights_(SightTable::of(real.camera, real.rig.camera)),
      projector_(real.projector.centre()),
      steepest_(scene.smoothness({-kEverywhere, kEverywhere, -kEverywhere, kEverywhere}).slope),
      gloss_(world.gloss) {
  if (world.texture) {
    texture_.emplace(*world.texture, world.seed);
  }
}

HeightRange LitSurface::all_heights(double t0, double t1) const {
  return scene_.range({-kEverywhere, kEverywhere, -kEverywhere, kEverywhere}, t0, t1);
}

Box LitSurface::between(const Box& tangents, HeightRange heights) const {
  const Point3 centre = camera_.centre();
  const double near = plane_z_ - heights.high - centre.z;
  const double far = plane_z_ - heights.low - centre.z;
  return {
      centre.x + tangents.x0 * (tangents.x0 < 0 ? far : near), centre.x + tangents.x1 * (tangents.x1 > 0 ? far : near),
      centre.y + tangents.y0 * (tangents.y0 < 0 ? far : near), centre.y + tangents.y1 * (tangents.y1 > 0 ? far : near)};
}

Box LitSurface::footprint(PixelPoint first, PixelPoint last, HeightRange heights) const {
  return between(tangents_of(camera_.corner_sights(first, last)), heights);
}

// The footprint between two heights gives bounds of the surface in it. These give a smaller footprint, and so on.
HeightRange LitSurface::heights_between(const Box& tangents, double t0, double t1, HeightRange all) const {
  HeightRange heights = all;
  constexpr int kTries = 8;
  constexpr double kWorthwhile = 0.9;
  for (int i = 0; i < kTries; ++i) {
    const HeightRange found = scene_.range(between(tangents, heights), t0, t1);
    const double before = heights.high - heights.low;
    heights = {std::max(heights.low, found.low), std::min(heights.high, found.high)};
    if (heights.high - heights.low > kWorthwhile * before) {
      break;
    }
  }
  return heights;
}

// Around such a point of a ray there is no slope, because all heights are the same number.
HeightRange LitSurface::plateau(const Box& tangents, double t0, double t1, HeightRange heights) const {
  if (!scene_.has_exact_levels()) {
    return heights;
  }
  const HeightRange found = heights_between(tangents, t0, t1, heights);
  if (found.low != found.high) {
    return heights;
  }
  constexpr double kAround = 2 * kSlopeStep;
  const Box box = between(tangents, found);
  const HeightRange around =
      scene_.range({box.x0 - kAround, box.x1 + kAround, box.y0 - kAround, box.y1 + kAround}, t0, t1);
  return around.low == found.low && around.high == found.low ? found : heights;
}

LitSurface::Hit LitSurface::hit_along(Point3 sight, double t, HeightRange heights) const {
  const Point3 centre = camera_.centre();
  const double z = plane_z_ - centre.z;
  const bool level = heights.high - heights.low <= kHeightTolerance;
  const double h = level ? heights.low
                         : first_hit(scene_, {centre.x + sight.x * z, -sight.x, centre.y + sight.y * z, -sight.y}, t,
                                     heights.low, heights.high);
  return {centre + (z - h) * sight, h, level};
}

Point3 LitSurface::normal(const Hit& hit, double t) const {
  const Point3 p = hit.point;
  const auto slope = [&](double dx, double dy) {
    return (scene_.height(p.x + dx, p.y + dy, t) - scene_.height(p.x - dx, p.y - dy, t)) / (2 * kSlopeStep);
  };
  // towards the camera, which is −z
  if (hit.level) {
    return {0, 0, -1};
  }
  const Point3 up{-slope(kSlopeStep, 0), -slope(0, kSlopeStep), -1};
  return 1 / std::sqrt(dot(up, up)) * up;
}

double LitSurface::incidence(Point3 point, Point3 normal) const {
  const Point3 to_projector = projector_ - point;
  const double distance_2 = dot(to_projector, to_projector);
  const double cosine = dot(normal, to_projector) / std::sqrt(distance_2);
  if (!(cosine > 0)) {
    return 0;
  }
  if (!falloff_) {
    return cosine;
  }
  const Point3 whole = Point3{0, 0, plane_z_} - projector_;
  return cosine * dot(whole, whole) / distance_2;
}

bool LitSurface::in_shadow(Point3 point, Point3 normal, double t, double highest) const {
  const Point3 start = point + kShadowLift * normal;
  const double low = plane_z_ - start.z;
  const double top = plane_z_ - projector_.z;  // height of the projector
  const double high = std::min(highest, top);
  if (low >= high) {
    return false;
  }
  if (is_above_all(start)) {
    return false;
  }
  const double dx = (projector_.x - start.x) / (top - low);
  const double dy = (projector_.y - start.y) / (top - low);
  return is_blocked(scene_, {start.x - dx * low, dx, start.y - dy * low, dy}, t, low, high);
}

LitSurface::Shadow LitSurface::shadow_on_level(const Box& tangents, double height, double t0, double t1,
                                               double highest) const {
  constexpr int kHalvings = 6;
  const double high = std::min(highest, plane_z_ - projector_.z);
  return height >= high ? Shadow::none
                        : shadow_in({between(tangents, {height, height}), height, t0, t1}, {height, high}, kHalvings);
}

// At the heights of the segment, all ways of the light lie within a box. If the surface in this box is nowhere above
// the segment, it blocks none of the ways; if it is above the segment everywhere, it blocks all of them.
LitSurface::Shadow LitSurface::shadow_in(const Beam& beam, HeightRange segment, int halvings) const {
  constexpr double kRounding = 1e-3;             // mm
  constexpr double kShortest = 2 * kShadowLift;  // mm; in_shadow overlooks nothing that is so high
  const double top = plane_z_ - projector_.z;
  const double a = (segment.low - beam.from) / (top - beam.from);  // shares of the way to the projector
  const double b = (segment.high - beam.from) / (top - beam.from);
  const auto at = [](double share, double from, double to) { return from + share * (to - from); };
  const auto least = [&](double from, double to) { return std::min(at(a, from, to), at(b, from, to)) - kRounding; };
  const auto most = [&](double from, double to) { return std::max(at(a, from, to), at(b, from, to)) + kRounding; };
  const HeightRange range = scene_.range({least(beam.start.x0, projector_.x), most(beam.start.x1, projector_.x),
                                          least(beam.start.y0, projector_.y), most(beam.start.y1, projector_.y)},
                                         beam.t0, beam.t1);
  if (range.high <= segment.low) {
    return Shadow::none;
  }
  segment.high = std::min(segment.high, range.high);
  if (segment.high - segment.low < kShortest) {
    return Shadow::some;
  }
  if (range.low >= segment.high) {
    return Shadow::all;
  }
  if (halvings == 0) {
    return Shadow::some;
  }
  const double middle = (segment.low + segment.high) / 2;
  const Shadow lower = shadow_in(beam, {segment.low, middle}, halvings - 1);
  const Shadow upper = lower == Shadow::all ? lower : shadow_in(beam, {middle, segment.high}, halvings - 1);
  return upper == Shadow::none ? lower : upper;
}

bool LitSurface::is_above_all(Point3 point) const {
  constexpr double kSurely = 0.9;
  const double up = point.z - projector_.z;
  return up > 0 && std::isfinite(steepest_) &&
         steepest_ * std::hypot(projector_.x - point.x, projector_.y - point.y) < kSurely * up;
}

// The texture is carried along with the part.
double LitSurface::albedo(Point3 point, double t) const {
  const double even = scene_.albedo(point.x, point.y, t);
  return texture_ ? even * texture_->at(point.x - scene_.speed() * t, point.y) : even;
}

double LitSurface::reflectance(Point3 point, Point3 normal, double albedo) const {
  if (!gloss_) {
    return albedo;
  }
  const auto direction = [&](Point3 to) {
    const Point3 way = to - point;
    return 1 / std::sqrt(dot(way, way)) * way;
  };
  return relative_radiance(*gloss_, albedo, normal, direction(projector_), direction(camera_.centre()));
}

double LitSurface::lit_share(const Hit& hit, double t, double highest) const {
  const Point3 up = normal(hit, t);
  const double share = incidence(hit.point, up);
  return share > 0 && !in_shadow(hit.point, up, t, highest) ? share : 0;
}

}  // namespace selfproj
