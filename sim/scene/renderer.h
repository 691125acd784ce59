// The camera's images of a scene under the projector's light. docs/simulation.md describes the model.
#ifndef SELFPROJ_SIM_SCENE_RENDERER_H
#define SELFPROJ_SIM_SCENE_RENDERER_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/rig/rig.h"
#include "sim/scene/block_grid.h"
#include "sim/scene/block_views.h"
#include "sim/scene/column_views.h"
#include "sim/scene/disturbed_camera.h"
#include "sim/scene/lens_kernel.h"
#include "sim/scene/level_blocks.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/renderer_frame.h"
#include "sim/scene/scene.h"
#include "sim/scene/world.h"

namespace selfproj {

// The disturbances of the measurement, each of which can be switched off, and an option of the light.
struct RenderOptions {
  bool shot_noise = true;
  bool read_noise = true;
  bool quantization = true;  // rounding to whole grey values 0..255, which 8-bit images have in any case
  bool camera_blur = true;
  bool projector_blur = true;
  bool motion_blur = true;  // if false, all light comes at the middle of the exposure
  bool falloff = false;  // light falls with the squared distance from the projector; as stated on the plane, x = y = 0
  World world = {};      // disturbances that are not in an ideal world: none

  // The same options without the disturbances of the world.
  [[nodiscard]] RenderOptions ideal_world() const {
    RenderOptions result = *this;
    result.world = {};
    return result;
  }
};

// A pattern of light 0..1 as the rig's projector throws it: with its gamma, its blur and its focus.
ProjectedLight throw_light(const Rig& rig, const FloatImage& pattern, const RenderOptions& options);

// Adds noise according to RenderOptions to an image of grey values. It is that of a frame of this number with this
// rig's seed: normal, of variance (grey - dark) / electrons_per_grey + read_noise^2. It does not depend on who made the
// image.
void add_noise(const RigImaging& imaging, const RenderOptions& options, int frame, std::span<float> pixels);

// Rounds grey values and limits them to 0..255.
void quantize(std::span<float> pixels);
void quantize(std::span<const float> from, std::span<std::uint8_t> to);

// The switches of RenderOptions that turn a source of error off, with the names that commands use.
struct Disturbance {
  const char* name;
  bool RenderOptions::*flag;
};
inline constexpr std::array<Disturbance, 6> kDisturbances{{
    {"shot-noise", &RenderOptions::shot_noise},
    {"read-noise", &RenderOptions::read_noise},
    {"quantization", &RenderOptions::quantization},
    {"camera-blur", &RenderOptions::camera_blur},
    {"projector-blur", &RenderOptions::projector_blur},
    {"motion-blur", &RenderOptions::motion_blur},
}};

// Options with everything on, except the disturbances of these names.
RenderOptions options_without(const std::vector<std::string>& names);

// Throws UserError about `source` if the pattern has not the projector's size, or has a value outside 0..1.
void check_pattern(const FloatImage& pattern, const RigProjector& projector, const std::string& source = "pattern");

class Renderer {
 public:
  // The scene must live as long as the renderer. The pattern has light 0..1, the projector's lines x columns. Throws as
  // check_pattern does.
  Renderer(const RealRig& real, const Scene& scene, const FloatImage& pattern, RenderOptions options = {});

  // Changes the projector's pattern. Like the constructor, but cheaper. No thread may be rendering.
  void set_pattern(const FloatImage& pattern);

  // The image of a frame (from 0), camera rows x columns, row by row. Does not depend on what was rendered before.
  // Several threads may call it at once.
  void render(int frame, std::span<std::uint8_t> pixels) const;

  // The same as floating-point grey values, which without quantization are neither rounded nor limited.
  void render(int frame, std::span<float> pixels) const;

  // The result of a light section without any error: for each camera column the height, mm, of the point where its
  // viewing plane, the light sheet (the middle of the projected line, ProjectedLight::line_centre) and the surface meet
  // at the middle of the exposure. NaN if the camera does not see the line, or sees it more than once. On a belt that
  // swings it swings as well: ask a renderer of the ideal world for the part.
  void truth(int frame, std::span<float> heights) const { truth(frame, heights, {}); }

  // The same, and the points themselves, one for each column; without meaning where the height is NaN.
  void truth(int frame, std::span<float> heights, std::span<Point3> points) const;

  // One such row for each of `count` frames from `first` on, with several threads (0: one for each core).
  [[nodiscard]] FloatImage truth(int first, int count, int threads = 0) const;

  // The surface's height, mm above the plane, at a place of the world at the middle of the frame's exposure. A measured
  // point (x, y, z) has the height error (plane_z − z) − true_height(frame, x, y).
  [[nodiscard]] double true_height(int frame, double x, double y) const;

 private:
  // Sub-pixels along a side of a pixel.
  static constexpr int kSub = kSubPixels;
  // Pixels along a side of the blocks that are checked for light as a whole.
  static constexpr int kBlock = kBlockPixels;

  using Hit = LitSurface::Hit;
  using Light = FrameLight;
  using Strip = SubPixelStrip;

  [[nodiscard]] double time_of(int frame) const { return frame / rig_.camera.frame_rate_hz; }
  [[nodiscard]] double time_of_shot(int frame) const;  // with its jitter
  [[nodiscard]] double ambient() const;  // grey values of ambient light, unless they are the same all over
  [[nodiscard]] double grey(const Hit& hit, double t, double highest) const;
  void sample_dark(const Light& light, int row, int column, HeightRange heights, BlockValues& values) const;

  // Samples a pixel of a block. `first` is the middle of its first sub-pixel, whose value goes to `to`.
  void sample_pixel(const Light& light, PixelPoint first, HeightRange heights, LitSurface::Shadow shadow,
                    float* to) const;

  // Samples a block and returns true. If it is known that all its values are 0, returns false.
  bool sample_block(const Light& light, int down, int across, BlockValues& values) const;

  // Samples a row of blocks.
  void sample_strip(const Light& light, int down, Strip& strip) const;
  [[nodiscard]] double miss(Point3 sight, double t, HeightRange heights) const;
  [[nodiscard]] std::optional<double> side_of_sheet(const Box& tangents, HeightRange heights) const;
  [[nodiscard]] std::optional<Hit> hit_on_sheet(double row, int column, double above, double t,
                                                HeightRange heights) const;
  void add_strip(const Strip& strip, int down, std::span<float> pixels) const;
  void expose(int frame, std::span<float> pixels) const;

  Rig rig_;
  const Scene& scene_;
  RenderOptions options_;
  std::shared_ptr<const Scene> swinging_;  // the scene as it is seen, if its belt swings
  Pinhole camera_;
  Pinhole projector_;
  std::shared_ptr<const LitSurface> lit_;  // at one place, however the renderer is moved
  const LitSurface& surface_;
  std::shared_ptr<const DisturbedCamera> disturbed_;
  ProjectedLight light_;
  BlockGrid grid_;  // with the margin around the image from which the lens gathers light
  BlockViews views_;
  std::shared_ptr<LevelBlocks> levels_;
  std::shared_ptr<const ColumnViews> column_views_;
  std::vector<float> kernel_;  // of pixel and lens, one weight for each sub-pixel: (2 margin + 1) kSub
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_RENDERER_H
