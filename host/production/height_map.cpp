#include "host/production/height_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/rig/geometry.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/rig/optics.h"

namespace selfproj::production {
namespace {

constexpr double kWidestBridge = 2;  // cells between two points that are joined

const rig::RigParts& parts_of(const rig::Rig& rig) {
  if (!rig.parts) {
    throw UserError(rig.name, "has no section `parts`, which says what a part is, and the grid of its map");
  }
  return *rig.parts;
}

MapGrid grid_of(const rig::Rig& rig) {
  const double pixel = pixel_mm(rig);
  const double pitch = parts_of(rig).grid_mm;
  if (pitch < pixel) {
    throw UserError(rig.name, fmt::format("parts.grid_mm is {}; the camera's pixels are {:.4g} mm apart on the plane",
                                          pitch, pixel));
  }
  MapGrid grid;
  grid.pitch_mm = pitch;
  grid.rows = static_cast<int>(std::ceil(rig.camera.rows * pixel / pitch)) + 1;
  grid.columns = static_cast<int>(std::ceil(rig.camera.columns * pixel / pitch)) + 1;
  grid.across_mm = -0.5 * (grid.columns - 1) * pitch;
  return grid;
}

}  // namespace

HeightGrid::HeightGrid(const rig::Rig& rig)
    : columns_(rig.camera.columns),
      plane_z_(rig.plane_z_mm),
      above_(rig.parts.value().above_mm),
      column_mm_(pixel_mm(rig)) {
  const rig::RigParts& parts = *rig.parts;
  if (parts.grid_mm < column_mm_) {
    throw UserError(rig.name, fmt::format("parts.grid_mm is {}; the camera's columns are {:.4g} mm apart on the plane",
                                          parts.grid_mm, column_mm_));
  }
  // What the camera sees of the plane, and how far a point may be from x = 0.
  const double across = rig.plane_z_mm * rig::tan_beta(rig.camera, columns_ - 0.5);
  const double reach = rig.plane_z_mm * rig::tan_alpha(rig.camera, rig.camera.rows + 0.5);
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

void HeightGrid::add(double belt_mm, const light_section::ProfileView& profile) {
  for (int i = 0; i < columns_; ++i) {
    Point& last = points_[static_cast<std::size_t>(i)];
    if (profile.validity[i] != static_cast<std::uint8_t>(light_section::Validity::valid)) {
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

double HeightGrid::width_above(const light_section::ProfileView& profile) const {
  const auto highest_z = static_cast<float>(plane_z_ - above_);
  int count = 0;
  for (int i = 0; i < columns_; ++i) {
    count +=
        profile.validity[i] == static_cast<std::uint8_t>(light_section::Validity::valid) && profile.z[i] < highest_z
            ? 1
            : 0;
  }
  return count * column_mm_;
}

DepthGrid::DepthGrid(const rig::Rig& rig)
    : plane_z_(rig.plane_z_mm),
      sums_(grid_of(rig)),
      x_per_z_(rig.camera.rows, rig.camera.columns, images::kNoValue),
      y_per_z_(rig.camera.rows, rig.camera.columns, images::kNoValue) {
  const rig::RigOptics optics(rig);
  for (int r = 0; r < rig.camera.rows; ++r) {
    for (int c = 0; c < rig.camera.columns; ++c) {
      if (const auto ray = optics.ray({static_cast<double>(r), static_cast<double>(c)})) {
        x_per_z_.row(r)[c] = static_cast<float>((*ray)[0]);
        y_per_z_.row(r)[c] = static_cast<float>((*ray)[1]);
      }
    }
  }
}

HeightCells DepthGrid::cells(const images::FloatImage& depth) {
  const MapGrid& grid = sums_.grid();
  const double middle = 0.5 * (grid.rows - 1);  // the row of x = 0
  sums_.clear();
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    const float z = depth.values[i];
    const float x = z * x_per_z_.values[i];
    if (std::isnan(x)) {
      continue;
    }
    sums_.put(middle + static_cast<double>(x) / grid.pitch_mm,
              grid.column_of(static_cast<double>(z * y_per_z_.values[i])),
              static_cast<float>(plane_z_ - static_cast<double>(z)));
  }
  return sums_.cells();
}

}  // namespace selfproj::production
