#include "host/production/height_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "host/files/user_error.h"
#include "host/light_section/profile.h"
#include "host/rig/geometry.h"

namespace selfproj {
namespace {

constexpr double kWidestBridge = 2;  // cells between two points that are joined

}  // namespace

HeightGrid::HeightGrid(const Rig& rig)
    : columns_(rig.camera.columns),
      plane_z_(rig.plane_z_mm),
      above_(rig.parts.value().above_mm),
      column_mm_(rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm) {
  const RigParts& parts = *rig.parts;
  if (parts.grid_mm < column_mm_) {
    throw UserError(rig.name, fmt::format("parts.grid_mm is {}; the camera's columns are {:.4g} mm apart on the plane",
                                          parts.grid_mm, column_mm_));
  }
  // What the camera sees of the plane, and how far a point may be from x = 0.
  const double across = rig.plane_z_mm * tan_beta(rig.camera, columns_ - 0.5);
  const double reach = rig.plane_z_mm * tan_alpha(rig.camera, rig.camera.rows + 0.5);
  const double along = parts.length_mm + 2 * parts.gap_mm + 2 * reach;
  MapGrid grid;
  grid.pitch_mm = parts.grid_mm;
  grid.columns = static_cast<int>(std::ceil(2 * across / parts.grid_mm)) + 1;
  grid.rows = static_cast<int>(std::ceil(along / parts.grid_mm)) + 2;
  grid.across_mm = -across;
  grid.along_mm = -reach;
  sums_ = CellSums(grid);
  points_.resize(static_cast<std::size_t>(columns_));
}

void HeightGrid::begin(double belt_mm) {
  begin_ = belt_mm;
  sums_.clear();
  std::fill(points_.begin(), points_.end(), Point{});
}

void HeightGrid::add(double belt_mm, const ProfileView& profile) {
  for (int i = 0; i < columns_; ++i) {
    Point& last = points_[static_cast<std::size_t>(i)];
    if (profile.validity[i] != static_cast<std::uint8_t>(Validity::valid)) {
      last.there = false;
      continue;
    }
    const double row = grid().row_of(belt_mm - begin_ - static_cast<double>(profile.x[i]));
    const double column = grid().column_of(profile.y[i]);
    const auto height = static_cast<float>(plane_z_ - static_cast<double>(profile.z[i]));
    sums_.put(row, column, height);
    const double way = std::abs(row - static_cast<double>(last.row));
    if (last.there && way > 1 && way <= kWidestBridge) {
      sums_.put(0.5 * (row + static_cast<double>(last.row)), 0.5 * (column + static_cast<double>(last.column)),
                0.5F * (height + last.height));
    }
    last = {static_cast<float>(row), static_cast<float>(column), height, true};
  }
}

double HeightGrid::width_above(const ProfileView& profile) const {
  const auto highest_z = static_cast<float>(plane_z_ - above_);
  int count = 0;
  for (int i = 0; i < columns_; ++i) {
    count += profile.validity[i] == static_cast<std::uint8_t>(Validity::valid) && profile.z[i] < highest_z ? 1 : 0;
  }
  return count * column_mm_;
}

}  // namespace selfproj
