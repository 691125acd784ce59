#include "sim/scene/bounce.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include "sim/scene/ray.h"

namespace selfproj {
namespace {

constexpr int kPatches = 64;  // along each side of the projector's image

}  // namespace

BounceLight::BounceLight(const RealRig& real, const Scene& scene, const LitSurface& surface, const Bounce& bounce)
    : real_(real),
      scene_(scene),
      surface_(surface),
      strength_(bounce.strength),
      down_((real.rig.camera.rows + kStep - 1) / kStep + 1),
      across_((real.rig.camera.columns + kStep - 1) / kStep + 1) {
  if (scene.speed() == 0) {
    receivers_ = receivers(0);
  }
}

// Patches of the projector's image in which there is light, each at the middle of its light. The irradiance does not
// depend on the distance, so a pixel's flux is its light times s² cos / (scales): its area at right angles to the
// light.
std::vector<BounceLight::Source> BounceLight::sources(const ProjectedLight& pattern, double t) const {
  const RigProjector& size = real_.rig.projector;
  const Pinhole& projector = real_.projector;
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
      const double zero = (real_.rig.plane_z_mm - centre.z) / along.z;  // depth along the axis at height 0
      const HeightRay ray{centre.x + along.x * zero, -along.x / along.z, centre.y + along.y * zero, -along.y / along.z};
      const double h = first_hit(scene_, ray, t, all.low, std::min(all.high, real_.rig.plane_z_mm - centre.z));
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
  const RigImaging& imaging = real_.rig.imaging;
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
  const int columns = real_.rig.camera.columns;
  for (int r = 0; r < real_.rig.camera.rows; ++r) {
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

}  // namespace selfproj
