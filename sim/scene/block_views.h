// What is the same in every frame for the blocks of an image: their sights, and the heights of the surface at which
// light of the pattern may fall on what they show.
#ifndef SELFPROJ_SIM_SCENE_BLOCK_VIEWS_H
#define SELFPROJ_SIM_SCENE_BLOCK_VIEWS_H

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/scene/block_grid.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/scene.h"

namespace selfproj {

class BlockViews {
 public:
  // `heights` are those that the surface can have. For others may_be_lit is always true.
  BlockViews(const RealRig& real, const BlockGrid& grid, HeightRange heights);

  // Prepares may_be_lit for a pattern. No other thread may call it meanwhile.
  void set_light(const ProjectedLight& light);

  // Whether no light falls on the points that the rays through a block meet between these heights.
  [[nodiscard]] bool is_dark(std::size_t block, HeightRange heights, const ProjectedLight& light) const;

  // False only if the light of set_light cannot fall on those points. It is a look-up, by slices of the heights.
  [[nodiscard]] bool may_be_lit(std::size_t block, HeightRange heights) const {
    if (!(heights.low >= heights_.low && heights.high <= heights_.high)) {
      return true;
    }
    const unsigned first = slice_of(heights.low);
    const unsigned last = std::max(first, slice_of(heights.high));
    const std::uint32_t from_low = ~std::uint32_t{0} << first;
    const std::uint32_t to_high = ~std::uint32_t{0} >> (kSlices - 1 - last);
    return (lit_[block] & from_low & to_high) != 0;
  }

  // The sights of a block's corners, and bounds of x and y of all its sights.
  [[nodiscard]] const std::array<Point3, 4>& corners(std::size_t block) const { return corners_[block]; }
  [[nodiscard]] const Box& tangents(std::size_t block) const { return tangents_[block]; }

 private:
  static constexpr unsigned kSlices = 32;  // of the heights, one for each bit

  [[nodiscard]] unsigned slice_of(double height) const {
    const auto slice = static_cast<unsigned>((height - heights_.low) * slices_per_mm_);
    return slice < kSlices ? slice : kSlices - 1;
  }
  [[nodiscard]] std::uint32_t lit_slices(std::size_t block, const ProjectedLight& light, unsigned first,
                                         unsigned count) const;

  double plane_z_;
  Point3 centre_;  // of the camera
  Pinhole projector_;
  HeightRange heights_;
  double slices_per_mm_;
  std::vector<std::array<Point3, 4>> corners_;
  std::vector<Box> tangents_;
  std::vector<std::uint32_t> lit_;  // for each block, the slices in which light may fall on it
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BLOCK_VIEWS_H
