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

#include "host/images/float_image.h"
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

// What a renderer simulates: sources of error, each of which can be switched off, the light, and the world.
struct RenderOptions {
  bool shot_noise = true;
  bool read_noise = true;
  bool quantization = true;  // rounding to whole grey values 0..255; 8-bit images are always rounded
  bool camera_blur = true;
  bool projector_blur = true;
  bool motion_blur = true;  // if false, all light comes at the middle of the exposure
  // Light decreases with the square of the distance from the projector. On the plane at x = y = 0 it is as strong as
  // without this option.
  bool falloff = false;
  World world = {};  // disturbances of the world; none by default

  // The same options without the disturbances of the world.
  [[nodiscard]] RenderOptions ideal_world() const {
    RenderOptions result = *this;
    result.world = {};
    return result;
  }
};

// Returns the light that the rig's projector makes of a pattern of light 0..1, with its gamma, blur and defocus.
ProjectedLight throw_light(const Rig& rig, const FloatImage& pattern, const RenderOptions& options);

// Adds shot noise and read noise, as switched on in `options`, to an image of grey values. The noise is normal, with
// variance (grey - dark) / electrons_per_grey + read_noise^2. The seed of `imaging` and the frame number determine it.
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

// Returns the default options with the disturbances of these names switched off.
RenderOptions options_without(const std::vector<std::string>& names);

// Throws UserError about `source` if the pattern does not have the projector's size, or has a value outside 0..1.
void check_pattern(const FloatImage& pattern, const RigProjector& projector, const std::string& source = "pattern");

class Renderer {
 public:
  // The scene must live as long as the renderer. The pattern has light 0..1, with a row for each line of the projector.
  // Throws as check_pattern() does.
  Renderer(const RealRig& real, const Scene& scene, const FloatImage& pattern, RenderOptions options = {});

  // Changes the projector's pattern. This is cheaper than a new renderer, and throws like the constructor. No thread
  // may render at the same time.
  void set_pattern(const FloatImage& pattern);

  // Renders the image of a frame (from 0), camera rows x columns, row by row. The image does not depend on what was
  // rendered before. Several threads may call this at once.
  void render(int frame, std::span<std::uint8_t> pixels) const;

  // Does the same with floating-point grey values. Without quantization they are neither rounded nor limited.
  void render(int frame, std::span<float> pixels) const;

  // Computes what a light section without any error would measure. For each camera column, this is the height (mm) of
  // the point that is on the column's viewing plane, on the light sheet and on the surface, at the middle of the
  // exposure. The light sheet is the middle of the projected line (ProjectedLight::line_centre). The height is NaN if
  // the camera does not see the line in this column, or sees it more than once. Vibration of the belt is included. To
  // get the truth of the part itself, use a renderer of the ideal world.
  void truth(int frame, std::span<float> heights) const { truth(frame, heights, {}); }

  // Does the same, and also gives the points, one for each column. Where the height is NaN, the point has no meaning.
  void truth(int frame, std::span<float> heights, std::span<Point3> points) const;

  // Returns a row of these heights for each of `count` frames from `first` on. 0 threads means one for each core.
  [[nodiscard]] FloatImage truth(int first, int count, int threads = 0) const;

  // Returns the surface's height at (x, y) in mm above the plane, at the middle of the frame's exposure. The height
  // error of a measured point (x, y, z) is (plane_z − z) − true_height(frame, x, y).
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
  [[nodiscard]] double ambient() const;  // grey value of ambient light at albedo 1; 0 if the albedo is even
  [[nodiscard]] double grey(const Hit& hit, double t, double highest) const;
  void sample_dark(const Light& light, int row, int column, HeightRange heights, BlockValues& values) const;

  // Samples a pixel of a block. `first` is the middle of the pixel's first sub-pixel. `to` is the place of this
  // sub-pixel's value in the block.
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
  std::shared_ptr<const Scene> swinging_;  // the scene with vibration of the belt; null without vibration
  Pinhole camera_;
  Pinhole projector_;
  std::shared_ptr<const LitSurface> lit_;  // on the heap, so that surface_ stays valid if the renderer is moved
  const LitSurface& surface_;
  std::shared_ptr<const DisturbedCamera> disturbed_;
  ProjectedLight light_;
  BlockGrid grid_;  // with the margin around the image from which the lens gathers light
  BlockViews views_;
  std::shared_ptr<LevelBlocks> levels_;
  std::shared_ptr<const ColumnViews> column_views_;
  std::vector<float> kernel_;  // (2 margin + 1) kSub weights of sub-pixels, for a pixel with the blur of the lens
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_RENDERER_H
