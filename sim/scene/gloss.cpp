#include "sim/scene/gloss.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace selfproj {

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

}  // namespace selfproj
