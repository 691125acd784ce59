// Light-section measurements of rendered scenes, self-projected and with a straight line, which experiments A1 and A2
// compare with the truth.
#ifndef SELFPROJ_LAB_SECTION_MEASUREMENT_H
#define SELFPROJ_LAB_SECTION_MEASUREMENT_H

#include <cstddef>
#include <functional>
#include <vector>

#include "host/report/report.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/rig/rig.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/world.h"

namespace selfproj::lab {

// The conventional method: a straight line, in the middle of the image at `middle_height` mm over the plane. The
// reference part is measured once as above.
sim::LightSection straight_line(const rig::Rig& rig, const sim::PerturbedRig& actual, const sim::Scene& reference,
                                const sim::RenderOptions& options, double middle_height);

// A measurement of a scene in each of kAllModes, and its truth. Row k of every map is the scene's frame frames[k].
struct Measurement {
  std::vector<int> frames;
  std::vector<light_section::Inspection> by_mode;
  images::FloatImage truth;   // LineRenderer::truth
  images::FloatImage true_x;  // of its points in the world, mm
  images::FloatImage true_y;
  report::CameraPicture camera;  // middle frame, with the moments of kAllModes[0]
  double line_peak = 0;          // median over the columns of the middle frame's greatest grey value
};

// Measures every `every`-th frame with several threads (0: one for each core). Without quantization it uses the
// renderer's floating-point grey values, though the reference's residual is always measured with 8 bits. `progress`
// gets the number of frames done.
Measurement measure(const sim::LightSection& setup, const sim::Scene& scene, const sim::RenderOptions& options,
                    int every, int threads, const std::function<void(std::size_t)>& progress);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_SECTION_MEASUREMENT_H
