// The camera's images of a scene under whole patterns of the projector, many frames of them: what does not move is
// traced once, when the renderer is made, and is then a look at the pattern for every sub-pixel; of a frame only what
// bodies cover or shade is traced anew.
//
//     PatternRenderer renderer(rig, scene);
//     const PatternSet patterns(rig, gray_patterns(rig, 8));
//     for (int frame = 0; frame < 1000; ++frame) renderer.render(frame, patterns.of_frame(frame), pixels);
#ifndef SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H
#define SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/io/image_files.h"
#include "host/rig/rig.h"
#include "sim/scene/body.h"
#include "sim/scene/lens_kernel.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

// An image as the rig's projector throws it: its lines x columns, 8 bits, 255 full light. Throws UserError about
// `source` where it has another size. `blur`: with the rig's.
ProjectedLight project_image(const Rig& rig, const Image& image, bool blur = true,
                             const std::string& source = "pattern");

// Patterns shown one after another, one a frame, over and over.
class PatternSet {
 public:
  // At least one. Throws as project_image, std::invalid_argument where there is none.
  PatternSet(const Rig& rig, std::span<const Image> images, bool blur = true);

  [[nodiscard]] int size() const { return static_cast<int>(light_.size()); }
  [[nodiscard]] const ProjectedLight& operator[](int pattern) const {
    return light_[static_cast<std::size_t>(pattern)];
  }
  // Frame k shows pattern k mod size().
  [[nodiscard]] const ProjectedLight& of_frame(int frame) const { return (*this)[frame % size()]; }

 private:
  std::vector<ProjectedLight> light_;
};

// The 2 bits patterns of (4.1) along the projector's lines, 0 and 255, lines x columns: positive and negative of plane
// 0 (the most significant), of plane 1, ... `bits` 1..12.
std::vector<Image> gray_patterns(const RigProjector& projector, int bits);

class PatternRenderer {
 public:
  // The scene must live as long. Its surface must stand still (speed() 0; that of t = 0 is taken); its bodies may move.
  // Throws std::invalid_argument where it does not. Traces the surface, by several threads (0: one a core).
  PatternRenderer(const Rig& rig, const Scene& scene, RenderOptions options = {}, int threads = 0);

  // The image of a frame (from 0) under this pattern, camera rows x columns, row by row: what Renderer would make of
  // it, with the bodies. The same every time, whatever was rendered before. May be called by several threads at once.
  void render(int frame, const ProjectedLight& pattern, std::span<std::uint8_t> pixels) const;

  // The same in grey values as numbers, which without quantization are neither rounded nor bounded.
  void render(int frame, const ProjectedLight& pattern, std::span<float> pixels) const;

  // The truth: z in mm of what each pixel's centre sees at the middle of the frame's exposure, of surface and bodies.
  // With lit_only NaN where the projector's light does not fall.
  void depth(int frame, std::span<float> z, bool lit_only = false) const { lit_depth(frame, z, lit_only ? 0 : -1); }

  // The same, NaN where full light of the projector adds no more grey values than this: what a scanner can measure.
  void lit_depth(int frame, std::span<float> z, float least_light) const;

  [[nodiscard]] const Rig& rig() const { return rig_; }

 private:
  static constexpr int kSub = kSubPixels;
  static constexpr int kBlock = 4;             // pixels along a side of a block
  static constexpr int kSide = kBlock * kSub;  // sub-pixels, likewise
  static constexpr int kSamples = kSide * kSide;
  using Values = std::array<float, static_cast<std::size_t>(kSamples)>;

  // What a ray of the camera meets.
  struct Spot {
    float z = 0;
    float line = 0, column = 0;  // of the projector
    float light = 0;             // grey values that full light of the projector adds; 0 in the shadow
    float ambient = 0;           // grey values without it
  };
  using Corners = std::array<Spot, 4>;  // upper left, upper right, lower left, lower right

  // Of the surface: a block whose spots lie linearly between those of its corners, or that has one a sub-pixel.
  struct Block {
    Corners corners;
    std::int64_t samples = -1;  // index of the first in samples_
  };

  struct Moment;
  struct Motion;
  struct Look;
  struct Parabola;
  using Nodes = std::array<Look, 9>;  // of a block: corners, middles of the sides, middle; row by row

  [[nodiscard]] double time_of(int frame) const { return frame / rig_.camera.frame_rate_hz; }
  [[nodiscard]] PixelPoint node_pixel(int down, int across) const;
  [[nodiscard]] PixelPoint sample_pixel(int down, int across, int i, int j) const;
  [[nodiscard]] Spot spot_of(Point3 point, double share, double albedo) const;
  [[nodiscard]] Spot still_spot(PixelPoint pixel, HeightRange heights) const;
  void trace_block(int down, int across, HeightRange all, Block& block, std::vector<Spot>& samples) const;
  [[nodiscard]] Spot still_sample(const Block& block, int i, int j) const;
  [[nodiscard]] Motion motion_of(int frame) const;
  void mark(std::size_t body, const Cuboid& bounds, std::vector<std::uint32_t>& seen,
            std::vector<std::uint32_t>& shaded) const;
  void narrow(Motion& motion, double way) const;
  [[nodiscard]] Look look(PixelPoint pixel, const Spot& still, const Moment& moment, std::uint32_t seen,
                          std::uint32_t shaded) const;
  void still_values(const Block& block, const ProjectedLight& pattern, bool dark, Values& values) const;
  void moving_values(const Motion& motion, int down, int across, const ProjectedLight& pattern, Values& values) const;
  [[nodiscard]] static bool is_smooth(const std::array<Nodes, 3>& looks);
  static void swept_values(const Nodes& begin, const Nodes& end, int passes, const ProjectedLight& pattern,
                           Values& values);
  void expose(int frame, const ProjectedLight& pattern, std::span<float> pixels) const;

  Rig rig_;
  const Scene& scene_;
  RenderOptions options_;
  Pinhole camera_;
  Pinhole projector_;
  LitSurface surface_;
  HeightRange heights_;  // of all the surface
  int margin_;
  std::vector<float> kernel_;
  int blocks_down_ = 0, blocks_across_ = 0;
  std::vector<Block> blocks_;
  std::vector<Spot> samples_;
  std::vector<Spot> nodes_;  // of the surface, at the corners of blocks, the middles of their sides, and their middles
  std::vector<Spot> centres_;  // of the surface, a pixel each
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PATTERN_RENDERER_H
