#include "sim/cosim/light_section.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/light_section/pattern.h"
#include "host/rig/geometry.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/light_section/reference.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::sim {

light_section::ReferenceCurve curve_of_scene(const rig::Rig& rig, const Scene& scene) {
  constexpr double kStep = 0.02;
  const light_section::MiddleRow row(rig);
  const double reach = rig.plane_z_mm * std::max(std::abs(row.tan_beta(-1)), row.tan_beta(rig.camera.columns)) + 1;
  const int middle = scene.frames() / 2;
  const double time = middle / rig.camera.frame_rate_hz;
  const int count = static_cast<int>(std::ceil(reach / kStep));
  light_section::ReferenceCurve curve;
  for (int i = -count; i <= count; ++i) {
    const double y = (i + 0.5) * kStep;  // avoids the places of steps
    curve.y_mm.push_back(y);
    curve.z_mm.push_back(rig.plane_z_mm - scene.height(0, y, time));
  }
  return curve;
}

namespace {

// The residual of the reference, if it is to be measured.
void take_out(LightSection& of, const Scene& reference, const RenderOptions& options, bool residual) {
  if (!residual) {
    return;
  }
  const auto centroids = scan_centroids(of.rig, of.actual, reference, of.pattern, options, kAllModes);
  for (std::size_t m = 0; m < kAllModes.size(); ++m) {
    of.references[m] = light_section::without_residual(of.rig, of.references[m], centroids[m]);
  }
}

}  // namespace

LightSection self_projection(const rig::Rig& rig, const PerturbedRig& actual, const Scene& reference,
                             const RenderOptions& options, bool residual) {
  if (rig.light_plane) {  // its line is what it is, and the section is where it is seen
    LightSection result{rig, actual, light_section::draw_straight_line(actual.rig, kLaserLine), {}};
    result.references.fill(light_section::reference_of_plane(rig));
    take_out(result, reference, options, residual);
    return result;
  }
  const light_section::ReferenceCurve curve = curve_of_scene(rig, reference);
  LightSection result{rig, actual, light_section::draw_pattern(rig, light_section::pattern_of_curve(rig, curve)), {}};
  result.references.fill(light_section::reference_of_curve(rig, curve));
  take_out(result, reference, options, residual);
  return result;
}

}  // namespace selfproj::sim
