#include "sim/scene/block_views.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "sim/scene/lit_surface.h"

namespace selfproj {

BlockViews::BlockViews(const RealRig& real, const BlockGrid& grid, HeightRange heights)
    : plane_z_(real.rig.plane_z_mm),
      centre_(real.camera.centre()),
      projector_(real.projector),
      heights_(heights),
      slices_per_mm_(heights.high > heights.low ? kSlices / (heights.high - heights.low) : 0),
      lit_(grid.blocks(), ~std::uint32_t{0}) {
  corners_.reserve(grid.blocks());
  tangents_.reserve(grid.blocks());
  for (int down = 0; down < grid.down(); ++down) {
    for (int across = 0; across < grid.across(); ++across) {
      const std::array<Point3, 4> corners = real.camera.corner_sights(grid.node_pixel(2 * down, 2 * across),
                                                                      grid.node_pixel(2 * down + 2, 2 * across + 2));
      corners_.push_back(corners);
      tangents_.push_back(tangents_of(corners));
    }
  }
}

bool BlockViews::is_dark(std::size_t block, HeightRange heights, const ProjectedLight& light) const {
  std::array<Point3, 8> points{};
  std::size_t count = 0;
  for (const Point3 sight : corners_[block]) {
    for (const double h : {heights.low, heights.high}) {
      points[count++] = centre_ + (plane_z_ - h - centre_.z) * sight;
    }
  }
  const std::optional<PixelBounds> b = projector_.bounds(points);
  return b && light.is_dark(b->row_0, b->row_1, b->column_0, b->column_1);
}

void BlockViews::set_light(const ProjectedLight& light) {
  for (std::size_t block = 0; block < lit_.size(); ++block) {
    lit_[block] = lit_slices(block, light, 0, kSlices);
  }
}

// Slices overlap a little, so that a height on their border is in both however it is rounded.
std::uint32_t BlockViews::lit_slices(std::size_t block, const ProjectedLight& light, unsigned first,
                                     unsigned count) const {
  constexpr double kOverlap = 1e-6;  // mm
  const double slice = (heights_.high - heights_.low) / kSlices;
  const HeightRange range{heights_.low + first * slice - kOverlap, heights_.low + (first + count) * slice + kOverlap};
  if (is_dark(block, range, light)) {
    return 0;
  }
  return count == 1
             ? std::uint32_t{1} << first
             : lit_slices(block, light, first, count / 2) | lit_slices(block, light, first + count / 2, count / 2);
}

}  // namespace selfproj
