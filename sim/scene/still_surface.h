// A surface that stands still before camera and projector. It is traced once; a pattern then costs one look-up for
// every sub-pixel.
#ifndef SELFPROJ_SIM_SCENE_STILL_SURFACE_H
#define SELFPROJ_SIM_SCENE_STILL_SURFACE_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/block_grid.h"
#include "sim/scene/light_spot.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

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
  StillSurface(const RealRig& real, const Scene& scene, const RenderOptions& options, int threads);

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

  RigImaging imaging_;
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

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_STILL_SURFACE_H
