#include "sim/scene/lit_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "sim/scene/random.h"
#include "sim/scene/scene.h"

namespace selfproj::sim {
namespace {

struct Segment {
  double low, high;  // heights
};

// Segments still to be examined. They are halves of halves; 64 halvings suffice for any size and tolerance.
class Segments {
 public:
  void push(Segment segment) { segments_[count_++] = segment; }
  bool pop(Segment& segment) {
    if (count_ == 0) {
      return false;
    }
    segment = segments_[--count_];
    return true;
  }

 private:
  std::array<Segment, 64> segments_;
  std::size_t count_ = 0;
};

HeightRange bounds(const Scene& scene, const HeightRay& ray, double t, Segment s) {
  const double xa = ray.x + ray.dx * s.low;
  const double xb = ray.x + ray.dx * s.high;
  const double ya = ray.y + ray.dy * s.low;
  const double yb = ray.y + ray.dy * s.high;
  return scene.range({std::min(xa, xb), std::max(xa, xb), std::min(ya, yb), std::max(ya, yb)}, t, t);
}

double height_under(const Scene& scene, const HeightRay& ray, double t, double h) {
  return scene.height(ray.x + ray.dx * h, ray.y + ray.dy * h, t);
}

// Whether the bounds shrank the segment too little for another try without halving it.
bool shrinks_slowly(Segment before, Segment after) { return after.high - after.low > 0.5 * (before.high - before.low); }

}  // namespace

double first_hit(const Scene& scene, const HeightRay& ray, double t, double low, double high) {
  Segments rest;
  Segment s{low, high};
  for (;;) {
    const HeightRange range = bounds(scene, ray, t, s);
    if (range.low >= s.high) {
      return s.high;  // already below the surface where the segment begins
    }
    const Segment shrunk{std::max(s.low, range.low), std::min(s.high, range.high)};
    const bool surely = range.low >= s.low;
    bool nothing = shrunk.high < shrunk.low;
    if (!nothing && shrunk.high - shrunk.low <= kHeightTolerance) {
      const double middle = (shrunk.low + shrunk.high) / 2;
      if (surely || height_under(scene, ray, t, shrunk.high) >= shrunk.low) {
        return middle;
      }
      nothing = true;
    }
    if (nothing) {
      if (!rest.pop(s)) {
        return low;
      }
    } else if (shrinks_slowly(s, shrunk)) {
      const double middle = (shrunk.low + shrunk.high) / 2;
      rest.push({shrunk.low, middle});
      s = {middle, shrunk.high};
    } else {
      s = shrunk;
    }
  }
}

bool is_blocked(const Scene& scene, const HeightRay& ray, double t, double low, double high) {
  Segments rest;
  Segment s{low, high};
  do {
    for (;;) {
      const HeightRange range = bounds(scene, ray, t, s);
      if (range.high <= s.low) {
        break;
      }
      const Segment shrunk{s.low, std::min(s.high, range.high)};
      if (range.low >= shrunk.high) {
        return true;
      }
      if (shrunk.high - shrunk.low <= kHeightTolerance) {
        if (height_under(scene, ray, t, shrunk.low) > shrunk.high) {
          return true;
        }
        break;
      }
      if (shrinks_slowly(s, shrunk)) {
        const double middle = (shrunk.low + shrunk.high) / 2;
        rest.push({middle, shrunk.high});
        s = {shrunk.low, middle};
      } else {
        s = shrunk;
      }
    }
  } while (rest.pop(s));
  return false;
}

double facets(double cosine, double roughness) {
  const double cos_2 = cosine * cosine;
  const double m_2 = roughness * roughness;
  return cosine > 0 ? std::exp((cos_2 - 1) / (cos_2 * m_2)) / (std::numbers::pi * m_2 * cos_2 * cos_2) : 0;
}

double relative_radiance(const Gloss& gloss, double albedo, Point3 normal, Point3 to_light, Point3 to_camera) {
  const double light = dot(normal, to_light);
  const double view = dot(normal, to_camera);
  if (!(light > 0 && view > 0)) {
    return 0;
  }
  const Point3 sum = to_light + to_camera;
  const Point3 half = 1 / std::sqrt(dot(sum, sum)) * sum;
  const double facet = dot(normal, half);
  const double incidence = dot(to_camera, half);
  const double fresnel = gloss.reflectance + (1 - gloss.reflectance) * std::pow(1 - incidence, 5);
  const double open = std::min({1.0, 2 * facet * view / incidence, 2 * facet * light / incidence});
  return albedo * gloss.diffuse +
         std::numbers::pi * facets(facet, gloss.roughness) * fresnel * open / (4 * light * view);
}

TextureField::TextureField(const Texture& texture, std::uint64_t seed)
    : amplitude_(texture.contrast * std::sqrt(2.0 / kWaves)) {
  EvenNumbers random(seed);
  const double k = 2 * std::numbers::pi / texture.scale_mm;
  const double first = random.next();
  for (std::size_t i = 0; i < waves_.size(); ++i) {
    const double direction = std::numbers::pi * (static_cast<double>(i) + first) / kWaves;
    waves_.at(i) = {k * std::cos(direction), k * std::sin(direction), 2 * std::numbers::pi * random.next()};
  }
}

double TextureField::at(double x, double y) const {
  constexpr double kLeast = 0.05;
  double sum = 0;
  for (const Wave& wave : waves_) {
    sum += std::cos(wave.along_x * x + wave.along_y * y + wave.phase);
  }
  return std::max(kLeast, 1 + amplitude_ * sum);
}

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

LitSurface::LitSurface(const PerturbedRig& actual, const Scene& scene, bool falloff, const World& world)
    : scene_(scene),
      plane_z_(actual.rig.plane_z_mm),
      falloff_(falloff),
      camera_(actual.camera),
      sights_(SightTable::of(actual.camera, actual.rig.camera)),
      projector_(actual.projector.centre()),
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

namespace {

constexpr int kPatches = 64;  // along each side of the projector's image

}  // namespace

BounceLight::BounceLight(const PerturbedRig& actual, const Scene& scene, const LitSurface& surface,
                         const Bounce& bounce)
    : actual_(actual),
      scene_(scene),
      surface_(surface),
      strength_(bounce.strength),
      down_((actual.rig.camera.rows + kStep - 1) / kStep + 1),
      across_((actual.rig.camera.columns + kStep - 1) / kStep + 1) {
  if (scene.speed() == 0) {
    receivers_ = receivers(0);
  }
}

// Patches of the projector's image in which there is light, each at the middle of its light. The irradiance does not
// depend on the distance, so a pixel's flux is its light times s² cos / (scales): its area at right angles to the
// light.
std::vector<BounceLight::Source> BounceLight::sources(const ProjectedLight& pattern, double t) const {
  const rig::RigProjector& size = actual_.rig.projector;
  const Pinhole& projector = actual_.projector;
  const Point3 centre = projector.centre();
  const HeightRange all = surface_.all_heights(t, t);
  const double per_pixel = 1 / std::abs(projector.intrinsics().row_scale * projector.intrinsics().column_scale);
  std::vector<Source> result;
  for (int i = 0; i < kPatches; ++i) {
    for (int j = 0; j < kPatches; ++j) {
      const auto light = pattern.in(i * size.lines / kPatches, (i + 1) * size.lines / kPatches - 1,
                                    j * size.columns / kPatches, (j + 1) * size.columns / kPatches - 1);
      if (!(light.sum > 0)) {
        continue;
      }
      const Point3 along = projector.ray(light.middle);
      if (!(along.z > 0)) {
        continue;
      }
      const double zero = (actual_.rig.plane_z_mm - centre.z) / along.z;  // depth along the axis at height 0
      const HeightRay ray{centre.x + along.x * zero, -along.x / along.z, centre.y + along.y * zero, -along.y / along.z};
      const double h = first_hit(scene_, ray, t, all.low, std::min(all.high, actual_.rig.plane_z_mm - centre.z));
      const double depth = zero - h / along.z;
      const LitSurface::Hit hit{centre + depth * along, h, all.high - all.low <= kHeightTolerance};
      const Point3 normal = surface_.normal(hit, t);
      const double cosine = surface_.incidence(hit.point, normal);
      if (!(cosine > 0)) {
        continue;
      }
      const double across = depth * depth * per_pixel / std::sqrt(dot(along, along));  // of a pixel, across the light
      const double albedo = surface_.albedo(hit.point, t);
      result.push_back({hit.point, normal, albedo * light.sum * across, light.pixels * across / cosine});
    }
  }
  return result;
}

std::vector<BounceLight::Receiver> BounceLight::receivers(double t) const {
  const HeightRange all = surface_.all_heights(t, t);
  const rig::RigImaging& imaging = actual_.rig.imaging;
  std::vector<Receiver> result;
  for (int i = 0; i < down_; ++i) {
    for (int j = 0; j < across_; ++j) {
      const LitSurface::Hit hit = surface_.hit({i * kStep + 0.0, j * kStep + 0.0}, t, all);
      result.push_back({hit.point, surface_.normal(hit, t),
                        strength_ * (imaging.white - imaging.ambient) * surface_.albedo(hit.point, t)});
    }
  }
  return result;
}

double BounceLight::received(const std::vector<Source>& sources, Point3 point, Point3 normal) {
  double sum = 0;
  for (const Source& source : sources) {
    const Point3 way = source.point - point;
    const double in = dot(way, normal);
    const double out = -dot(way, source.normal);
    if (in > 0 && out > 0) {
      const double distance_2 = dot(way, way);
      sum += source.flux * in * out / (distance_2 * (std::numbers::pi * distance_2 + source.area));
    }
  }
  return sum;
}

double BounceLight::irradiance(const ProjectedLight& pattern, double t, Point3 point, Point3 normal) const {
  return strength_ * received(sources(pattern, t), point, normal);
}

void BounceLight::add(const ProjectedLight& pattern, double t, std::span<float> pixels) const {
  const std::vector<Source> lights = sources(pattern, t);
  const std::vector<Receiver> moved = receivers_.empty() ? receivers(t) : std::vector<Receiver>();
  const std::vector<Receiver>& seen = receivers_.empty() ? moved : receivers_;
  std::vector<double> grey(seen.size());
  std::transform(seen.begin(), seen.end(), grey.begin(),
                 [&](const Receiver& to) { return to.grey * received(lights, to.point, to.normal); });
  const int columns = actual_.rig.camera.columns;
  for (int r = 0; r < actual_.rig.camera.rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double* from = grey.data() + static_cast<std::ptrdiff_t>(r / kStep) * across_ + c / kStep;
      const double down = static_cast<double>(r % kStep) / kStep;
      const double across = static_cast<double>(c % kStep) / kStep;
      pixels[static_cast<std::size_t>(r * columns + c)] +=
          static_cast<float>((1 - down) * ((1 - across) * from[0] + across * from[1]) +
                             down * ((1 - across) * from[across_] + across * from[across_ + 1]));
    }
  }
}

}  // namespace selfproj::sim
