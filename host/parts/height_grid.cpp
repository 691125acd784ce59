#include "host/parts/height_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "host/io/user_error.h"
#include "host/light_section/profile.h"
#include "host/rig/geometry.h"

namespace selfproj {
namespace {

constexpr float kLeastWeight = 0.25F;  // of a cell that counts: less is the mere shadow of a neighbour
constexpr double kWidestBridge = 2;    // cells between two points that are joined

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
  grid_.pitch_mm = parts.grid_mm;
  grid_.columns = static_cast<int>(std::ceil(2 * across / parts.grid_mm)) + 1;
  grid_.rows = static_cast<int>(std::ceil(along / parts.grid_mm)) + 2;
  grid_.across_mm = -across;
  grid_.along_mm = -reach;
  sums_.resize(2 * static_cast<std::size_t>(grid_.rows) * static_cast<std::size_t>(grid_.columns));
  points_.resize(static_cast<std::size_t>(columns_));
}

void HeightGrid::begin(double belt_mm) {
  begin_ = belt_mm;
  const auto row = 2 * static_cast<std::ptrdiff_t>(grid_.columns);
  if (first_ <= last_) {
    std::fill(sums_.begin() + first_ * row, sums_.begin() + (last_ + 1) * row, 0.0F);
  }
  first_ = grid_.rows;
  last_ = -1;
  std::fill(points_.begin(), points_.end(), Point{});
}

void HeightGrid::put(double row, double column, float height) {
  const int r = static_cast<int>(std::floor(row));
  const int c = static_cast<int>(std::floor(column));
  if (r < 0 || c < 0 || r + 1 >= grid_.rows || c + 1 >= grid_.columns) {
    return;
  }
  const auto fr = static_cast<float>(row - r);
  const auto fc = static_cast<float>(column - c);
  float* const at = sums_.data() + 2 * (static_cast<std::ptrdiff_t>(r) * grid_.columns + c);
  float* const below = at + 2 * static_cast<std::ptrdiff_t>(grid_.columns);
  const float w00 = (1 - fr) * (1 - fc);
  const float w01 = (1 - fr) * fc;
  const float w10 = fr * (1 - fc);
  const float w11 = fr * fc;
  at[0] += w00;
  at[1] += w00 * height;
  at[2] += w01;
  at[3] += w01 * height;
  below[0] += w10;
  below[1] += w10 * height;
  below[2] += w11;
  below[3] += w11 * height;
  first_ = std::min(first_, r);
  last_ = std::max(last_, r + 1);
}

void HeightGrid::add(double belt_mm, const ProfileView& profile) {
  for (int i = 0; i < columns_; ++i) {
    Point& last = points_[static_cast<std::size_t>(i)];
    if (profile.validity[i] != static_cast<std::uint8_t>(Validity::valid)) {
      last.there = false;
      continue;
    }
    const double row = grid_.row_of(belt_mm - begin_ - static_cast<double>(profile.x[i]));
    const double column = grid_.column_of(profile.y[i]);
    const auto height = static_cast<float>(plane_z_ - static_cast<double>(profile.z[i]));
    put(row, column, height);
    const double way = std::abs(row - static_cast<double>(last.row));
    if (last.there && way > 1 && way <= kWidestBridge) {
      put(0.5 * (row + static_cast<double>(last.row)), 0.5 * (column + static_cast<double>(last.column)),
          0.5F * (height + last.height));
    }
    last = {static_cast<float>(row), static_cast<float>(column), height, true};
  }
}

HeightCells HeightGrid::cells() const {
  HeightCells result;
  result.grid = grid_;
  result.grid.rows = std::max(0, last_ - first_ + 1);
  result.grid.along_mm = grid_.along_of(std::min(first_, grid_.rows));
  result.height = FloatImage(result.grid.rows, grid_.columns, kNoValue);
  result.weight = FloatImage(result.grid.rows, grid_.columns);
  const float* from = sums_.data() + 2 * static_cast<std::ptrdiff_t>(first_) * grid_.columns;
  for (std::size_t i = 0; i < result.height.values.size(); ++i, from += 2) {
    result.weight.values[i] = from[0];
    if (from[0] >= kLeastWeight) {
      result.height.values[i] = from[1] / from[0];
    }
  }
  return result;
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
