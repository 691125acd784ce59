// Light-section measurements of rendered scenes, self-projected and with a straight line: what the experiments A1 and
// A2 compare with the truth.
#ifndef SELFPROJ_SIM_EXPERIMENT_LIGHT_SECTION_H
#define SELFPROJ_SIM_EXPERIMENT_LIGHT_SECTION_H

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "host/io/float_image.h"
#include "host/light_section/inspection.h"
#include "host/light_section/reference.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "model/column_moments.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

inline constexpr std::array<Mode, 3> kAllModes = {Mode::grey_over, Mode::grey, Mode::binary};

// What is set up before the part comes: rig, pattern, and the reference for each of kAllModes.
struct LightSection {
  Rig rig;
  FloatImage pattern;
  std::array<ReferenceProfile, kAllModes.size()> references;
};

// The section x = 0 of the scene at the middle of its way, every 0.02 mm of what the camera sees.
ReferenceCurve curve_of_scene(const Rig& rig, const Scene& scene);

// Self-projection with the pattern that belongs to the reference part, known as a shape. With `residual` the reference
// part is measured once (16 frames of it, with noise of their own), and what is left of each column's offset is kept.
// `real` is what camera and projector are like, `rig` what is believed of them, from which everything is computed;
// their images have one size.
LightSection self_projection(const Rig& rig, const Rig& real, const Scene& reference, const RenderOptions& options,
                             bool residual);

// The conventional method: a straight line in the middle of the image at `middle_height` mm over the plane, the
// reference part measured once as above.
LightSection straight_line(const Rig& rig, const Scene& reference, const RenderOptions& options, double middle_height);

// What was measured of a scene, in each of kAllModes, and what there was to be measured. Row k of every map is the
// scene's frame frames[k].
struct Measurement {
  std::vector<int> frames;
  std::vector<Inspection> by_mode;
  FloatImage truth;      // Renderer::truth
  CameraPicture camera;  // of the middle frame, moments of kAllModes[0]
  double line_peak = 0;  // median over the columns of the greatest grey value of the middle frame
};

// Measures every `every`-th frame by several threads; without quantization from the renderer's grey values as numbers
// (the reference's residual is always measured with 8 bits) (0: one a core). `progress` is told how many are done.
Measurement measure(const LightSection& setup, const Scene& scene, const RenderOptions& options, int every, int threads,
                    const std::function<void(std::size_t)>& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_LIGHT_SECTION_H
