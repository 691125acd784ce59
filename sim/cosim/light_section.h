// Self-projection onto a scene whose shape is known: its pattern and its references.
#ifndef SELFPROJ_SIM_COSIM_LIGHT_SECTION_H
#define SELFPROJ_SIM_COSIM_LIGHT_SECTION_H

#include <array>

#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj::sim {

inline constexpr std::array<model::Mode, 3> kAllModes = {model::Mode::grey_over, model::Mode::grey,
                                                         model::Mode::binary};

// The setup before the part comes: the rig that is believed, the one that takes the images, the pattern, and the
// reference for each of kAllModes.
struct LightSection {
  rig::Rig rig;
  PerturbedRig actual;
  images::FloatImage pattern;
  std::array<light_section::ReferenceProfile, kAllModes.size()> references;
};

// The section x = 0 of the scene at the middle of its way, every 0.02 mm over what the camera sees.
light_section::ReferenceCurve curve_of_scene(const rig::Rig& rig, const Scene& scene);

// Self-projection with the pattern of the reference part, whose shape is known. With `residual` the reference part is
// measured once (16 frames with separate noise), and each column's remaining offset is kept. `actual` describes camera
// and projector as they are. `rig` describes them as they are believed to be, and everything is computed from it. Their
// images have one size.
LightSection self_projection(const rig::Rig& rig, const PerturbedRig& actual, const Scene& reference,
                             const RenderOptions& options, bool residual);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_COSIM_LIGHT_SECTION_H
