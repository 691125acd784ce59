// The camera's images of a scene under the projector's light. README.md beside this file has the model.
#ifndef SELFPROJ_SIM_SCENE_RENDERER_H
#define SELFPROJ_SIM_SCENE_RENDERER_H

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/rig/rig.h"
#include "sim/scene/lens_kernel.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"

namespace selfproj {

// What disturbs the measurement, each to be switched off alone, and what makes the light.
struct RenderOptions {
  bool shot_noise = true;
  bool read_noise = true;
  bool quantization = true;  // to whole grey values 0..255; the 8-bit images have it in any case
  bool camera_blur = true;
  bool projector_blur = true;
  bool motion_blur = true;  // false: all light comes at the middle of the exposure
  bool falloff = false;  // light falls with the distance from the projector, squared; as stated on the plane, x = y = 0
};

// Adds the noise of RenderOptions to an image of grey values, which a frame of this number has with this rig's seed:
// normal, of variance (grey - dark) / electrons_per_grey + read_noise^2. The same whoever made the image.
void add_noise(const RigImaging& imaging, const RenderOptions& options, int frame, std::span<float> pixels);

// Grey values to whole ones, bounded to 0..255.
void quantize(std::span<float> pixels);
void quantize(std::span<const float> from, std::span<std::uint8_t> to);

// The switches of RenderOptions that turn a source of error off, by the names that commands take.
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

// Everything on but the disturbances of these names.
RenderOptions options_without(const std::vector<std::string>& names);

// Throws UserError about `source` where the pattern has not the projector's size or a value that is not 0..1.
void check_pattern(const FloatImage& pattern, const RigProjector& projector, const std::string& source = "pattern");

class Renderer {
 public:
  // The scene must live as long as the renderer. The pattern has the light 0..1 of the projector's lines x columns.
  // Throws as check_pattern.
  Renderer(const Rig& rig, const Scene& scene, const FloatImage& pattern, RenderOptions options = {});

  // Puts another pattern into the projector; as the constructor, but cheaper. Not while another thread renders.
  void set_pattern(const FloatImage& pattern);

  // The image of a frame (from 0), camera rows x columns, row by row. The same every time, whatever was rendered
  // before. May be called by several threads at once.
  void render(int frame, std::span<std::uint8_t> pixels) const;

  // The same in grey values as numbers, which without quantization are neither rounded nor bounded.
  void render(int frame, std::span<float> pixels) const;

  // What the light section measures in a frame without any error: of each camera column the height, mm, of the point
  // where its viewing plane, the light sheet (the middle of the projected line, ProjectedLight::line_centre) and the
  // surface at the middle of the exposure meet. NaN where the camera does not see the line, or sees it more than once.
  void truth(int frame, std::span<float> heights) const;

  // One such row a frame, `count` frames from `first` on, by several threads (0: one a core).
  [[nodiscard]] FloatImage truth(int first, int count, int threads = 0) const;

  // The surface's height, mm above the plane, at a place of the world at the middle of the frame's exposure. A measured
  // point (x, y, z) has the height error (plane_z − z) − true_height(frame, x, y).
  [[nodiscard]] double true_height(int frame, double x, double y) const;

 private:
  // Sub-pixels along a side of a pixel.
  static constexpr int kSub = kSubPixels;
  // Pixels along a side of the blocks that are looked at for light as a whole.
  static constexpr int kBlock = 4;

  using Hit = LitSurface::Hit;
  struct Light;  // of one frame, while it is rendered

  [[nodiscard]] double time_of(int frame) const { return frame / rig_.camera.frame_rate_hz; }
  [[nodiscard]] HeightRange block_heights(const Light& light, int row, int column) const;
  [[nodiscard]] bool is_dark(int row, int column, HeightRange heights) const;
  [[nodiscard]] double grey(const Hit& hit, double t, double highest) const;
  void sample_block(const Light& light, int row, int column, HeightRange heights, bool dark, float* to) const;
  void expose(int frame, std::span<float> pixels) const;

  Rig rig_;
  const Scene& scene_;
  RenderOptions options_;
  Pinhole camera_;
  Pinhole projector_;
  LitSurface surface_;
  ProjectedLight light_;
  int margin_;                 // pixels around the image that the lens's blur draws from
  std::vector<float> kernel_;  // of pixel and lens, one weight a sub-pixel: (2 margin + 1) kSub
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_RENDERER_H
