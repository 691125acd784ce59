// Heights of parts on even grids of millimetres, made of profiles or of depth images.
#ifndef SELFPROJ_HOST_PRODUCTION_HEIGHT_MAP_H
#define SELFPROJ_HOST_PRODUCTION_HEIGHT_MAP_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// Where the cells of a map lie. `along` is the direction in which rows follow each other: what comes later has more of
// it, so it is -x of the part. `across` is y. Both in mm. Cell (r, c) has its middle at
//     along = along_mm + r pitch_mm,   across = across_mm + c pitch_mm
struct MapGrid {
  int rows = 0;
  int columns = 0;
  double pitch_mm = 0;
  double along_mm = 0;
  double across_mm = 0;

  [[nodiscard]] double row_of(double along) const { return (along - along_mm) / pitch_mm; }
  [[nodiscard]] double column_of(double across) const { return (across - across_mm) / pitch_mm; }
  [[nodiscard]] double along_of(double row) const { return along_mm + row * pitch_mm; }
  [[nodiscard]] double across_of(double column) const { return across_mm + column * pitch_mm; }
  bool operator==(const MapGrid&) const = default;
};

// The heights of a part as they were measured, before it is placed: mm above the plane, NaN where nothing was seen.
// `weight` says how many points each cell is the mean of.
struct HeightCells {
  MapGrid grid;
  images::FloatImage height;
  images::FloatImage weight;
};

// Each point gives its height to the four cells around it, by its nearness, and a cell is the mean of what it got.
// Memory is allocated once.
class CellSums {
 public:
  CellSums() = default;
  explicit CellSums(const MapGrid& grid)
      : grid_(grid), sums_(2 * static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.columns)) {
    clear();
  }

  [[nodiscard]] const MapGrid& grid() const { return grid_; }

  void clear() {
    if (first_ <= last_) {
      const auto row = 2 * static_cast<std::ptrdiff_t>(grid_.columns);
      std::fill(sums_.begin() + first_ * row, sums_.begin() + (last_ + 1) * row, 0.0F);
    }
    first_ = grid_.rows;
    last_ = -1;
  }

  // Adds a point at a place in cells. A point outside of the grid is left out.
  void put(double row, double column, float height) {
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

  // The cells so far, without rows at both ends that have no point.
  [[nodiscard]] HeightCells cells() const {
    constexpr float kMinWeight = 0.25F;  // of a cell that counts: less is the mere shadow of a neighbour
    HeightCells result;
    result.grid = grid_;
    result.grid.rows = std::max(0, last_ - first_ + 1);
    result.grid.along_mm = grid_.along_of(std::min(first_, grid_.rows));
    result.height = images::FloatImage(result.grid.rows, grid_.columns, images::kNoValue);
    result.weight = images::FloatImage(result.grid.rows, grid_.columns);
    const float* from = sums_.data() + 2 * static_cast<std::ptrdiff_t>(first_) * grid_.columns;
    for (std::size_t i = 0; i < result.height.values.size(); ++i, from += 2) {
      result.weight.values[i] = from[0];
      if (from[0] >= kMinWeight) {
        result.height.values[i] = from[1] / from[0];
      }
    }
    return result;
  }

 private:
  MapGrid grid_;
  int first_ = 0;  // rows that got a point
  int last_ = -1;
  std::vector<float> sums_;  // of weights and of heights, by turns
};

// What a rig sees of its belt or table, in the rig's axes, mm. Those of a camera that leans, and of a laser, are where
// they are: the line may lie far from x = 0, and more of the belt to one side of y = 0.
struct BeltView {
  double column_mm = 0;              // distance of neighbouring columns on the plane
  double along_mm = 0;               // x of the light on the plane, in the middle of the image
  double reach_mm = 0;               // how far from there points may be along
  double left_mm = 0, right_mm = 0;  // y
};
BeltView belt_view(const rig::Rig& rig);

// The rig's section `parts`. Throws UserError, naming the rig, if it has none.
const rig::RigParts& parts_of(const rig::Rig& rig);

// How parts are cut where nothing is known of them: by their profile, on a grid as fine as the camera's columns allow.
// Lengths are multiples of the grid's; a part may be twice as long as the view is wide. Throws as belt_view() does.
rig::RigParts usual_parts(const rig::Rig& rig, bool by_encoder);

// The distance of the camera's pixels on the plane, mm.
inline double pixel_mm(const rig::Rig& rig) { return belt_view(rig).column_mm; }

// Collects the profiles of one part. Each point gives its height to the four cells around it, by its nearness, and a
// cell is the mean of what it got: the grid is even, however the belt moves. Between two points that follow each other
// in a column, at most two cells apart, places are filled in on the straight line, so that a belt that is a little too
// fast leaves no holes. Memory is that of the greatest part, and is allocated once.
class HeightGrid {
 public:
  // The grid of the rig's section `parts`, which must be there. Throws UserError, naming the rig, if its camera's
  // columns are further apart than the cells.
  explicit HeightGrid(const rig::Rig& rig);

  // Begins a part whose first frame is at this place of the belt, mm.
  void begin(double belt_mm);

  // Adds the profile of a frame. Points further along than the grid are left out.
  void add(double belt_mm, const light_section::ProfileView& profile);

  // The map of the part so far, without rows that have no point: along counts from the belt_mm of begin().
  [[nodiscard]] HeightCells cells() const { return sums_.cells(); }

  // How much of the profile is higher than above_mm of the rig, across, mm.
  [[nodiscard]] double width_above(const light_section::ProfileView& profile) const;

  [[nodiscard]] const MapGrid& grid() const { return sums_.grid(); }

 private:
  int columns_;  // of the camera
  double plane_z_;
  double above_;
  double column_mm_;  // distance of the camera's columns on the plane
  double light_x_;    // where the light lies on the plane
  double begin_ = 0;
  CellSums sums_;
  struct Point {
    float row = 0, column = 0, height = 0;
    bool there = false;
  };
  std::vector<Point> points_;  // the last point of each camera column
};

// Depth images of a scanner as heights above its plane, on an even grid over what the camera sees of the plane. along
// is x and across is y; along counts from the upper border of the view.
class DepthGrid {
 public:
  // Throws UserError, naming the rig, if it has no section `parts`, or its pixels are further apart than the cells.
  explicit DepthGrid(const rig::Rig& rig);

  // The cells of a depth image, z in mm, of the camera's size; NaN where there is none.
  [[nodiscard]] HeightCells cells(const images::FloatImage& depth);

  // How much of the plane the camera sees, mm.
  [[nodiscard]] double length_mm() const { return sums_.grid().pitch_mm * (sums_.grid().rows - 1); }
  [[nodiscard]] double across_mm() const { return -sums_.grid().across_mm; }  // to each side

 private:
  double plane_z_;
  CellSums sums_;
  images::FloatImage x_per_z_;  // of each pixel's ray; NaN where the lens model has none
  images::FloatImage y_per_z_;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_HEIGHT_MAP_H
