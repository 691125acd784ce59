// Lays a part on the reference by its edges.
#ifndef SELFPROJ_HOST_PRODUCTION_PLACEMENT_H
#define SELFPROJ_HOST_PRODUCTION_PLACEMENT_H

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/production/height_map.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

enum class Edge : std::size_t { leading, trailing, left, right };
inline constexpr std::size_t kEdges = 4;
inline constexpr std::array<const char*, kEdges> kEdgeNames = {"leading", "trailing", "left", "right"};

// A straight edge of a part: a point in the middle of it, and its angle in radians. The angle is against the across
// axis for leading and trailing edges and against the along axis for left and right ones; its sign means the same
// rotation for all four.
struct EdgeLine {
  double along_mm = 0;
  double across_mm = 0;
  double turn_rad = 0;
  double rms_mm = 0;      // RMS distance from the line of the places that count
  std::size_t count = 0;  // places that count
};

using EdgeLines = std::array<std::optional<EdgeLine>, kEdges>;

// The edges of the largest thing that is higher than above_mm of `rule`. What is lower or has no point, such as the
// shadow of a wall, does not split it if it is less than gap_mm wide. Each is a straight line through the places where
// it begins or ends in a row or column of cells, located to a fraction of a cell from the cells' weights; places far
// off the line (a chipped corner) do not count. A side edge at the border of the view is missing, and so is any edge
// with fewer than kMinPlaces places.
inline constexpr std::size_t kMinPlaces = 8;
EdgeLines edges_of(const HeightCells& cells, const rig::RigParts& rule);

// The outline of a good part. A value is missing if it is not known, for example because the part is wider than the
// view.
struct Outline {
  std::optional<double> length_mm = {};
  std::optional<double> left_mm = {};  // across
  std::optional<double> right_mm = {};
};

// How a part lies, and what remains of its edges once it is placed. A place (v, w) of the reference, v along from the
// leading edge of the outline, w across, is seen at
//     along  =  (v + along_mm) cos turn + (w + offset_mm) sin turn
//     across = -(v + along_mm) sin turn + (w + offset_mm) cos turn
struct Placement {
  double along_mm = 0;
  double offset_mm = 0;
  double turn_rad = 0;
  double across_mm = 0;    // how far its middle is shifted across
  double residual_mm = 0;  // RMS distance of its edges' places from their lines, and of the lines from the outline
  std::optional<double> length_mm = {};  // of this part
  std::optional<double> width_mm = {};
  std::string edges;  // those it was placed by, "leading left right"; empty: not placed by edges

  [[nodiscard]] double seen_along(double v, double w) const;
  [[nodiscard]] double seen_across(double v, double w) const;
};

// The placement of a part with these edges: turned by the mean of their angles, each weighted by the cube of its number
// of places and by how straight it is; shifted so that the middle between opposite edges, or the one that is there,
// lies where the outline has it. There is none unless the part has a leading edge, or a trailing edge and the outline's
// length is known.
std::optional<Placement> place_by_edges(const EdgeLines& edges, const Outline& outline);

// The heights of the part on the reference's grid, linear between the cells; NaN outside of the map, and where cells
// with less than half of the weight have a height.
images::FloatImage placed_heights(const HeightCells& cells, const Placement& placement, const MapGrid& grid);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_PLACEMENT_H
