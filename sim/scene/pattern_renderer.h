// The camera's images of a scene under whole patterns of the projector, for many frames. Still surfaces are traced
// once, when the renderer is made; a frame then only looks up the pattern for every sub-pixel. Only pixels that bodies
// cover or shade are traced again in each frame.
//
//     PatternRenderer renderer(rig, scene);
//     const PatternSet patterns(rig, gray_patterns(rig.projector, 8));
//     for (int frame = 0; frame < 1000; ++frame) renderer.render(frame, patterns.of_frame(frame), pixels);
#ifndef SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H
#define SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/block_fold.h"
#include "sim/scene/block_grid.h"
#include "sim/scene/body_motion.h"
#include "sim/scene/pattern_set.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/still_surface.h"

namespace selfproj {

class PatternRenderer {
 public:
  // The scene must live as long as the renderer, which cannot be copied or moved. Its table does not swing: of
  // vibration only that of the camera matters. Its surface must stand still (speed() is 0; that of t = 0 is used); its
  // bodies may move. Throws std::invalid_argument if it moves. Traces the surface with several threads (0: one for each
  // core).
  PatternRenderer(const RealRig& real, const Scene& scene, RenderOptions options = {}, int threads = 0);

  // The image of a frame (from 0) under this pattern, camera rows x columns, row by row, as Renderer would make it,
  // with bodies. Does not depend on what was rendered before. Several threads may call it at once.
  void render(int frame, const ProjectedLight& pattern, std::span<std::uint8_t> pixels) const;

  // The same as floating-point grey values, which without quantization are neither rounded nor limited.
  void render(int frame, const ProjectedLight& pattern, std::span<float> pixels) const;

  // The truth: z in mm of the point that each pixel's centre sees at the middle of the frame's exposure, on surface or
  // bodies.
  void depth(int frame, std::span<float> z) const { lit_depth(frame, z, -1); }

  // The same, but NaN if full light of the projector adds no more grey values than `least_light`: places without light,
  // or too dark for a scanner to measure.
  void lit_depth(int frame, std::span<float> z, float least_light = 0) const;

  [[nodiscard]] const Rig& rig() const { return rig_; }
  [[nodiscard]] const RenderOptions& options() const { return options_; }

 private:
  [[nodiscard]] double time_of_shot(int frame) const;  // with its jitter
  [[nodiscard]] BodyMotion motion_of(int frame) const;
  void moving_values(const BodyMotion& motion, int down, int across, const ProjectedLight& pattern,
                     BlockValues& values) const;
  void expose(int frame, const ProjectedLight& pattern, std::span<float> pixels) const;

  Rig rig_;
  const Scene& scene_;
  RenderOptions options_;
  StillSurface still_;
  std::unique_ptr<const DisturbedCamera> disturbed_;
  BlockFold fold_;
  std::vector<float> dark_;  // the image of the surface without light of the projector and without bodies
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H
