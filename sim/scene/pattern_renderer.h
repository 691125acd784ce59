// The camera's images of a scene under whole patterns of the projector, for many frames. Still surfaces are traced
// once, when the renderer is made; a frame then only looks up the pattern for every sub-pixel. Only pixels that bodies
// cover or shade are traced again in each frame.
//
//     PatternRenderer renderer(rig, scene);
//     const PatternSet patterns(rig, gray_patterns(rig.projector, 8));
//     for (int frame = 0; frame < 1000; ++frame) renderer.render(frame, patterns.of_frame(frame), pixels);
#ifndef SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H
#define SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H

#include <span>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/blocks.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/still_surface.h"

namespace selfproj::sim {

class PatternRenderer final : public Renderer {
 public:
  // The scene's table does not swing: of vibration only that of the camera matters. Its surface must stand still
  // (speed() is 0; that of t = 0 is used); its bodies may move. Throws std::invalid_argument if it moves. Traces the
  // surface with several threads (0: one for each core).
  PatternRenderer(const PerturbedRig& actual, const Scene& scene, const RenderOptions& options = {}, int threads = 0);

  using Renderer::render;  // with bodies

  // The truth: z in mm of the point that each pixel's centre sees at the middle of the frame's exposure, on surface or
  // bodies.
  void depth(int frame, std::span<float> z) const { lit_depth(frame, z, -1); }

  // The same, but NaN if full light of the projector adds no more grey values than `min_light`: places without light,
  // or too dark for a scanner to measure.
  void lit_depth(int frame, std::span<float> z, float min_light = 0) const;

 private:
  [[nodiscard]] BodyMotion motion_of(int frame) const;
  void moving_values(const BodyMotion& motion, int down, int across, const ProjectedLight& pattern,
                     BlockValues& values) const;
  void expose(int frame, const ProjectedLight& pattern, std::span<float> pixels) const override;
  void depths(int frame, std::span<float> z) const override { depth(frame, z); }

  StillSurface still_;
  std::vector<float> dark_;  // the image of the surface without light of the projector and without bodies
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H
