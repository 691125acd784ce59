// Gloss: light that a surface throws back mostly about the mirror's direction, by a microfacet model.
#ifndef SELFPROJ_SIM_SCENE_GLOSS_H
#define SELFPROJ_SIM_SCENE_GLOSS_H

#include "sim/scene/pinhole.h"

namespace selfproj {

struct Gloss {
  double diffuse = 1;      // factor of the albedo
  double reflectance = 0;  // of a facet at normal incidence, 0..1
  double roughness = 0.1;  // RMS slope of the facets, > 0
};

// The share of the facets' area whose normal has this cosine to the surface's, per steradian (Beckmann):
// D = exp(-tan² / m²) / (π m² cos⁴). The integral of D cos over the half space is 1.
double facets(double cosine, double roughness);

// The light towards the camera, relative to that of a white surface that scatters evenly, under the same irradiance:
// albedo · diffuse + π D F G / (4 (n·l) (n·v)), with Schlick's F and the G of Cook and Torrance (1982). All directions
// have length 1. 0 unless light and camera are above the surface.
double relative_radiance(const Gloss& gloss, double albedo, Point3 normal, Point3 to_light, Point3 to_camera);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_GLOSS_H
