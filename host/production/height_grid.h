// Profiles at any places of the belt, as a map on an even grid.
#ifndef SELFPROJ_HOST_PRODUCTION_HEIGHT_GRID_H
#define SELFPROJ_HOST_PRODUCTION_HEIGHT_GRID_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/light_section/profile.h"
#include "host/production/cell_sums.h"
#include "host/production/map_grid.h"
#include "host/rig/rig.h"

namespace selfproj {

// Collects the profiles of one part. Each point gives its height to the four cells around it, by its nearness, and a
// cell is the mean of what it got: the grid is even, however the belt moves. Between two points that follow each other
// in a column, at most two cells apart, places are filled in on the straight line, so that a belt that is a little too
// fast leaves no holes. Memory is that of the greatest part, and is taken once.
class HeightGrid {
 public:
  // The grid of the rig's section `parts`, which must be there. Throws UserError, naming the rig, if its camera's
  // columns are further apart than the cells.
  explicit HeightGrid(const Rig& rig);

  // Begins a part whose first frame is at this place of the belt, mm.
  void begin(double belt_mm);

  // Adds the profile of a frame. Points further along than the grid are left out.
  void add(double belt_mm, const ProfileView& profile);

  // The map of the part so far, without rows that have no point: along counts from the belt_mm of begin().
  [[nodiscard]] HeightCells cells() const { return sums_.cells(); }

  // How much of the profile is higher than above_mm of the rig, across, mm.
  [[nodiscard]] double width_above(const ProfileView& profile) const;

  [[nodiscard]] const MapGrid& grid() const { return sums_.grid(); }

 private:
  int columns_;  // of the camera
  double plane_z_;
  double above_;
  double column_mm_;  // distance of the camera's columns on the plane
  double begin_ = 0;
  CellSums sums_;
  struct Point {
    float row = 0, column = 0, height = 0;
    bool there = false;
  };
  std::vector<Point> points_;  // the last point of each camera column
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_HEIGHT_GRID_H
