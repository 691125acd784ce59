// Light-section measurements of rendered scenes, self-projected and with a straight line, which experiments A1 and A2
// compare with the truth.
#ifndef SELFPROJ_SIM_COSIM_LIGHT_SECTION_H
#define SELFPROJ_SIM_COSIM_LIGHT_SECTION_H

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "host/images/float_image.h"
#include "host/light_section/inspection.h"
#include "host/light_section/reference.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "model/column_moments.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

inline constexpr std::array<Mode, 3> kAllModes = {Mode::grey_over, Mode::grey, Mode::binary};

// The setup before the part comes: the rig that is believed, the one that takes the images, the pattern, and the
// reference for each of kAllModes.
struct LightSection {
  Rig rig;
  RealRig real;
  FloatImage pattern;
  std::array<ReferenceProfile, kAllModes.size()> references;
};

// The section x = 0 of the scene at the middle of its way, every 0.02 mm over what the camera sees.
ReferenceCurve curve_of_scene(const Rig& rig, const Scene& scene);

// Self-projection with the pattern of the reference part, whose shape is known. With `residual` the reference part is
// measured once (16 frames with separate noise), and each column's remaining offset is kept. `real` describes camera
// and projector as they are. `rig` describes them as they are believed to be, and everything is computed from it. Their
// images have one size.
LightSection self_projection(const Rig& rig, const RealRig& real, const Scene& reference, const RenderOptions& options,
                             bool residual);

// The conventional method: a straight line, in the middle of the image at `middle_height` mm over the plane. The
// reference part is measured once as above.
LightSection straight_line(const Rig& rig, const RealRig& real, const Scene& reference, const RenderOptions& options,
                           double middle_height);

// A measurement of a scene in each of kAllModes, and its truth. Row k of every map is the scene's frame frames[k].
struct Measurement {
  std::vector<int> frames;
  std::vector<Inspection> by_mode;
  FloatImage truth;   // Renderer::truth
  FloatImage true_x;  // of its points in the world, mm
  FloatImage true_y;
  CameraPicture camera;  // middle frame, with the moments of kAllModes[0]
  double line_peak = 0;  // median over the columns of the middle frame's greatest grey value
};

// Measures every `every`-th frame with several threads (0: one for each core). Without quantization it uses the
// renderer's floating-point grey values, though the reference's residual is always measured with 8 bits. `progress`
// gets the number of frames done.
Measurement measure(const LightSection& setup, const Scene& scene, const RenderOptions& options, int every, int threads,
                    const std::function<void(std::size_t)>& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_LIGHT_SECTION_H
