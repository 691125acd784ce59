// What images under patterns need of a scene: its surface, which stands still and is traced once, and the bodies that
// move before it.
#ifndef SELFPROJ_SIM_SCENE_STILL_SURFACE_H
#define SELFPROJ_SIM_SCENE_STILL_SURFACE_H

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/blocks.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/optics.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "sim/scene/world.h"

namespace selfproj::sim {

// The point that a ray of the camera meets, with the properties on which images under patterns depend.
struct LightSpot {
  float z = 0;                 // mm
  float line = 0, column = 0;  // place in the projector's image
  float light = 0;             // grey values added by full light of the projector; 0 in the shadow
  float ambient = 0;           // grey values without the projector

  // The grey value under a pattern.
  [[nodiscard]] float grey(const ProjectedLight& pattern) const {
    return light == 0 ? ambient : ambient + light * pattern.quick_at(line, column, z);
  }
};

inline float mix(float a, float b, float share) { return a + share * (b - a); }

inline LightSpot mix(const LightSpot& a, const LightSpot& b, float share) {
  return {mix(a.z, b.z, share), mix(a.line, b.line, share), mix(a.column, b.column, share),
          mix(a.light, b.light, share), mix(a.ambient, b.ambient, share)};
}

// In this order: upper left, upper right, lower left, lower right.
using SpotCorners = std::array<LightSpot, 4>;

// Linear between the corners. `down` and `across` are shares 0..1.
inline LightSpot between(const SpotCorners& corners, float down, float across) {
  return mix(mix(corners[0], corners[2], down), mix(corners[1], corners[3], down), across);
}

// Whether no member differs by more than the same member of `tolerance`.
inline bool alike(const LightSpot& a, const LightSpot& b, const LightSpot& tolerance) {
  return std::abs(a.z - b.z) <= tolerance.z && std::abs(a.line - b.line) <= tolerance.line &&
         std::abs(a.column - b.column) <= tolerance.column && std::abs(a.light - b.light) <= tolerance.light &&
         std::abs(a.ambient - b.ambient) <= tolerance.ambient;
}

// Bounds of the projector's lines and columns that light several spots.
struct SpotBounds {
  float line_0 = std::numeric_limits<float>::max();
  float line_1 = std::numeric_limits<float>::lowest();
  float column_0 = std::numeric_limits<float>::max();
  float column_1 = std::numeric_limits<float>::lowest();

  void add(const LightSpot& spot) {
    line_0 = std::min(line_0, spot.line);
    line_1 = std::max(line_1, spot.line);
    column_0 = std::min(column_0, spot.column);
    column_1 = std::max(column_1, spot.column);
  }

  // Bounds of a pattern's light in that rectangle.
  [[nodiscard]] MinMaxPyramid::Range light_of(const ProjectedLight& pattern) const {
    return pattern.range(static_cast<double>(line_0), static_cast<double>(line_1), static_cast<double>(column_0),
                         static_cast<double>(column_1));
  }
};

// If light varies over a block by no more than this, it counts as one value.
inline constexpr float kSameLight = 1e-4F;

// How far the contents of a block may deviate from linear for its corners to represent it.
inline constexpr float kPlaceTolerance = 0.02F;  // projector lines and columns
inline constexpr float kGreyTolerance = 0.2F;
inline constexpr float kDepthTolerance = 0.05F;  // mm

// A surface that stands still before camera and projector. It is traced once; a pattern then costs one look-up for
// every sub-pixel.

// Whether the projector's light reaches what is seen.
enum class Shade : std::uint8_t { lit, dark };

class StillSurface {
 public:
  // A block whose spots are linear between its corners, or which has one spot for each sub-pixel.
  struct Block {
    SpotCorners corners;
    std::int64_t samples = -1;  // index of the first one; -1: linear
  };

  // Traces the scene's surface at t = 0 with several threads (0: one for each core). The scene must live as long as
  // this.
  StillSurface(const PerturbedRig& actual, const Scene& scene, const RenderOptions& options, int threads);

  [[nodiscard]] const BlockGrid& grid() const { return grid_; }
  [[nodiscard]] const Pinhole& camera() const { return camera_; }
  [[nodiscard]] const Pinhole& projector() const { return projector_; }
  [[nodiscard]] const LitSurface& surface() const { return surface_; }
  [[nodiscard]] HeightRange heights() const { return heights_; }  // of the whole surface

  // The points that the rays through a node and through a pixel's middle meet. Indices are those of the grid, and row
  // by row.
  [[nodiscard]] const LightSpot& node(std::size_t index) const { return nodes_[index]; }
  [[nodiscard]] const LightSpot& centre(std::size_t pixel) const { return centres_[pixel]; }
  [[nodiscard]] const Block& block(std::size_t index) const { return blocks_[index]; }

  // The point that the ray through sub-pixel (i, j) of a block meets.
  [[nodiscard]] LightSpot sample(const Block& block, int i, int j) const {
    if (block.samples >= 0) {
      return samples_[static_cast<std::size_t>(block.samples + i * kBlockSide + j)];
    }
    return between(block.corners, (static_cast<float>(i) + 0.5F) / kBlockSide,
                   (static_cast<float>(j) + 0.5F) / kBlockSide);
  }

  // Whether no light of a pattern falls on a block.
  [[nodiscard]] bool is_dark(std::size_t block, const ProjectedLight& pattern) const {
    return bounds_[block].light_of(pattern).high <= 0;
  }

  // Grey values of a block under a pattern: lit as the surface is, or all in the shadow.
  void values(std::size_t index, const ProjectedLight& pattern, Shade shade, BlockValues& values) const;

  // The properties of a point that a ray meets. `share` of the projector's full light is that of LitSurface::lit_share;
  // `albedo` is for ambient light, and `reflectance` for the projector's.
  [[nodiscard]] LightSpot spot_of(Point3 point, double share, double albedo, double reflectance) const;

 private:
  [[nodiscard]] LightSpot trace(PixelPoint pixel, HeightRange heights) const;
  [[nodiscard]] bool is_smooth(int down, int across, HeightRange heights, const Block& block) const;
  [[nodiscard]] SpotBounds bounds_of(const Block& block) const;
  void trace_block(int down, int across, Block& block, std::vector<LightSpot>& samples) const;

  rig::RigImaging imaging_;
  Pinhole camera_;
  Pinhole projector_;
  LitSurface surface_;
  HeightRange heights_;
  BlockGrid grid_;
  std::vector<Block> blocks_;
  std::vector<SpotBounds> bounds_;  // of the spots of each block
  std::vector<LightSpot> samples_;
  std::vector<LightSpot> nodes_;
  std::vector<LightSpot> centres_;
};

// The bodies of a scene during the exposure of a frame, and the blocks of the image in which they matter.

// The exposure is sampled at kSubPixels (optics.h) * passes instants, each sub-pixel at `passes` of them. Without
// bodies, `instants` and the masks are empty.
struct BodyMotion {
  int passes = 1;
  std::array<Bodies, 3> ends;    // at the beginning, middle and end of the exposure
  std::vector<Bodies> instants;  // the bodies at each of these instants
  // For each block, bit i of `seen` is set if body i may be seen in it, and bit i of `shaded` if the shadow of body i
  // may fall on what is seen in it.
  std::vector<std::uint32_t> seen;
  std::vector<std::uint32_t> shaded;

  // Whether bodies may matter in a block.
  [[nodiscard]] bool touches(std::size_t block) const { return !seen.empty() && (seen[block] | shaded[block]) != 0; }
};

// `middle` and `exposure` are in s; an exposure of 0 is an instant.
BodyMotion body_motion(const rig::Rig& rig, const Scene& scene, const StillSurface& still, double middle,
                       double exposure);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_STILL_SURFACE_H
