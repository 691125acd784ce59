// Even grids of millimetres, on which parts are looked at.
#ifndef SELFPROJ_HOST_PRODUCTION_MAP_GRID_H
#define SELFPROJ_HOST_PRODUCTION_MAP_GRID_H

#include "host/images/float_image.h"

namespace selfproj {

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
  FloatImage height;
  FloatImage weight;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_MAP_GRID_H
