// The reference of structured light as a map: where it can be compared with, its regions, and its tolerance.
#ifndef SELFPROJ_HOST_PRODUCTION_MAP_REFERENCE_H
#define SELFPROJ_HOST_PRODUCTION_MAP_REFERENCE_H

#include <string>
#include <vector>

#include "host/images/float_image.h"
#include "host/production/map_grid.h"
#include "host/production/tolerance.h"
#include "host/rig/rig.h"

namespace selfproj {

// The heights on the rig's grid without those at walls, which say more about the place than about the part: where the
// three cells to a side rise by more than kSteepest, and kBesideWalls camera pixels beside.
FloatImage without_steep_places(const FloatImage& heights, const Rig& rig);

// The surfaces of a reference as polygons on its placed map: each connected stretch of places that can be compared
// with, less a strip of edge_mm at its border, if it has at least 16 times the smallest area. A surface within another
// one belongs to both. The bands have no meaning.
std::vector<ToleranceRegion> map_regions(const FloatImage& comparable, const MapGrid& grid, double edge_mm,
                                         double smallest_mm2);

// The heights across the middle of the reference, every step_mm from left_mm on, NaN where there is none: what a
// tolerance stores of it.
std::vector<double> middle_section(const HeightCells& reference, const Tolerance& outline, double step_mm);

// Throws UserError, naming `source`, if the tolerance places parts by their edges, its part leaves the view, or it was
// made for another part: the heights across the middle differ from the stored ones by more than kOtherPart mm or 1 % of
// the distance to the plane in more than half of the places.
void check_map_tolerance(const Tolerance& tolerance, const Rig& rig, const HeightCells& reference,
                         const std::string& source);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_MAP_REFERENCE_H
