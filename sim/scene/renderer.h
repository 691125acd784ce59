// The camera's images of a scene under the projector's light. docs/simulation.md describes the model.
#ifndef SELFPROJ_SIM_SCENE_RENDERER_H
#define SELFPROJ_SIM_SCENE_RENDERER_H

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/blocks.h"
#include "sim/scene/camera_errors.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/optics.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "sim/scene/world.h"

namespace selfproj::sim {

// What every image goes through: the exposure, which a derived class makes, disturbances of the camera, noise and
// quantization. A renderer cannot be copied or moved, and its scene must live as long.
class Renderer {
 public:
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  virtual ~Renderer() = default;

  [[nodiscard]] const rig::Rig& rig() const { return rig_; }
  [[nodiscard]] const RenderOptions& options() const { return options_; }

 protected:
  Renderer(const PerturbedRig& actual, const Scene& scene, const RenderOptions& options);

  // Renders the image of a frame (from 0), camera rows x columns, row by row. The image does not depend on what was
  // rendered before. Several threads may call this at once.
  void render(int frame, const ProjectedLight& light, std::span<std::uint8_t> pixels) const;

  // Does the same with pixels of the rig's bits, and with floating-point grey values. Without quantization these are
  // neither rounded nor limited.
  void render(int frame, const ProjectedLight& light, std::span<std::uint16_t> pixels) const;
  void render(int frame, const ProjectedLight& light, std::span<float> pixels) const;

  // Times of a frame's middle in s, as planned and with its jitter; and how long it is exposed: 0 without motion blur.
  [[nodiscard]] double time_of(int frame) const { return frame / rig_.camera.frame_rate_hz; }
  [[nodiscard]] double time_of_shot(int frame) const;
  [[nodiscard]] double exposure() const { return options_.motion_blur ? rig_.camera.exposure_s : 0; }

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const BlockFold& fold() const { return fold_; }
  [[nodiscard]] const BlockGrid& grid() const { return fold_.grid(); }

  // Adds the disturbances of the world that the camera has. `surface` is what it sees of the scene; both must live as
  // long as the renderer.
  void disturb(const PerturbedRig& actual, const Scene& scene, const LitSurface& surface);

 private:
  // The image without noise and disturbances of the camera; and z in mm of what the middle of each pixel sees at the
  // middle of the exposure.
  virtual void expose(int frame, const ProjectedLight& light, std::span<float> pixels) const = 0;
  virtual void depths(int frame, std::span<float> z) const = 0;

  rig::Rig rig_;
  const Scene& scene_;
  RenderOptions options_;
  BlockFold fold_;  // its grid has the margin around the image from which the lens gathers light
  std::unique_ptr<const DisturbedCamera> disturbed_;
};

// Images of a surface that may move, under one pattern: a line of light, as a light section has it. It shows no bodies.
class LineRenderer final : public Renderer {
 public:
  // The pattern has light 0..1, with a row for each line of the projector. Throws as check_pattern() does.
  LineRenderer(const PerturbedRig& actual, const Scene& scene, const images::FloatImage& pattern,
               const RenderOptions& options = {});

  // Changes the projector's pattern. This is cheaper than a new renderer, and throws like the constructor. No thread
  // may render at the same time.
  void set_pattern(const images::FloatImage& pattern);

  // The images of Renderer.
  void render(int frame, std::span<std::uint8_t> pixels) const { Renderer::render(frame, light_, pixels); }
  void render(int frame, std::span<std::uint16_t> pixels) const { Renderer::render(frame, light_, pixels); }
  void render(int frame, std::span<float> pixels) const { Renderer::render(frame, light_, pixels); }

  // Computes what a light section without any error would measure. For each camera column, this is the height (mm) of
  // the point that is on the column's viewing plane, on the light sheet and on the surface, at the middle of the
  // exposure. The light sheet is the middle of the projected line (ProjectedLight::line_centre). The height is NaN if
  // the camera does not see the line in this column, or sees it more than once. Vibration of the belt is included. To
  // get the truth of the part itself, use a renderer of the ideal world.
  void truth(int frame, std::span<float> heights) const { truth(frame, heights, {}); }

  // Does the same, and also gives the points, one for each column. Where the height is NaN, the point has no meaning.
  void truth(int frame, std::span<float> heights, std::span<Point3> points) const;

  // Returns a row of these heights for each of `count` frames from `first` on. 0 threads means one for each core.
  [[nodiscard]] images::FloatImage truth(int first, int count, int threads = 0) const;

  // Returns the surface's height at (x, y) in mm above the plane, at the middle of the frame's exposure. The height
  // error of a measured point (x, y, z) is (plane_z − z) − true_height(frame, x, y).
  [[nodiscard]] double true_height(int frame, double x, double y) const;

 private:
  using Hit = LitSurface::Hit;

  // Values that are the same for all pixels of a frame.
  struct FrameLight {
    double middle;        // middle of the exposure, s
    double exposure;      // s; 0 without motion blur
    int passes;           // how many instants each sub-pixel is sampled at
    HeightRange heights;  // of the whole scene during the exposure

    [[nodiscard]] double first() const { return middle - exposure / 2; }
    [[nodiscard]] double last() const { return middle + exposure / 2; }
  };

  [[nodiscard]] double ambient() const;  // grey value of ambient light at albedo 1; 0 if the albedo is even
  [[nodiscard]] double grey(const Hit& hit, double t, double highest) const;
  void sample_dark(const FrameLight& light, int row, int column, HeightRange heights, BlockValues& values) const;

  // Samples a pixel of a block. `first` is the middle of the pixel's first sub-pixel. `to` is the place of this
  // sub-pixel's value in the block.
  void sample_pixel(const FrameLight& light, PixelPoint first, HeightRange heights, LitSurface::Shadow shadow,
                    float* to) const;

  // Samples a block and returns true. If it is known that all its values are 0, returns false.
  bool sample_block(const FrameLight& light, int down, int across, BlockValues& values) const;

  // Samples a row of blocks.
  void sample_strip(const FrameLight& light, int down, SubPixelStrip& strip) const;
  [[nodiscard]] double miss(Point3 sight, double t, HeightRange heights) const;
  [[nodiscard]] std::optional<double> side_of_sheet(const Box& tangents, HeightRange heights) const;
  [[nodiscard]] std::optional<Hit> hit_on_sheet(double row, int column, double above, double t,
                                                HeightRange heights) const;
  void expose(int frame, const ProjectedLight& light, std::span<float> pixels) const override;
  void depths(int frame, std::span<float> z) const override;

  std::unique_ptr<const Scene> swinging_;  // the scene with vibration of the belt; null without vibration
  Pinhole camera_;
  Pinhole projector_;
  LitSurface surface_;
  ProjectedLight light_;
  BlockViews views_;
  std::unique_ptr<LevelBlocks> levels_;
  ColumnViews column_views_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_RENDERER_H
