// What a good part may be: the tolerance file.
#ifndef SELFPROJ_HOST_PRODUCTION_TOLERANCE_H
#define SELFPROJ_HOST_PRODUCTION_TOLERANCE_H

#include <optional>
#include <string>
#include <vector>

#include "host/production/height_map.h"
#include "host/production/part_reference.h"
#include "host/production/placement.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// A polygon on the placed map, and the band in which the difference from the reference must be there.
struct ToleranceRegion {
  std::string name;
  std::vector<double> corners_mm;  // along, across, along, across, ... of at least three corners
  double low_mm = 0;
  double high_mm = 0;
  double max_missing = 0;  // share of its places that may have no point
};

struct Tolerance {
  bool by_edges = true;  // parts are placed by their edges; otherwise they lie as they were cut
  double length_mm = 0;  // of a good part, and where its edges are across
  double left_mm = 0;
  double right_mm = 0;
  double max_shift_mm = 0;     // across
  double max_turn_deg = 0;     // to both sides
  double max_residual_mm = 0;  // of the placement
  double min_defect_mm2 = 0;   // area of the smallest defect
  // The strip along edges and walls that the regions leave out; nothing: not known, regions may reach up to them.
  std::optional<double> edge_mm = {};
  // The section of the reference for which it was made, every section_step_mm from left_mm on; NaN where there was
  // none. Empty: it does not say.
  double section_step_mm = 0;
  std::vector<double> section_mm;
  std::vector<ToleranceRegion> regions;

  [[nodiscard]] Outline outline() const { return {length_mm, left_mm, right_mm}; }
};

// The grid of the placed map: that of the rig's cells, over the outline and kMapMargin around it.
inline constexpr double kMapMargin = 2;  // mm
MapGrid placed_grid(double pitch_mm, double length_mm, double left_mm, double right_mm);

// The file's text, and the tolerance of such a text. Throws UserError with `source`, line, key and reason if it is
// none, a number is out of its range, there is no region, or a region has no area or reaches out of the map.
std::string to_yaml(const Tolerance& tolerance);
Tolerance parse_tolerance(const std::string& yaml, const std::string& source);
Tolerance load_tolerance(const std::string& file);

// The section that the tolerance stores, of this reference.
std::vector<double> sampled_section(const SectionReference& section, double left_mm, double right_mm, double step_mm,
                                    double widest_mm);

// Throws UserError, naming `source`, if the tolerance was made for another part than the reference: the outline leaves
// the view of the rig, or the section differs from the stored one by more than kOtherPart mm.
inline constexpr double kOtherPart = 1;
void check_tolerance(const Tolerance& tolerance, const rig::Rig& rig, const SectionReference& section,
                     const std::string& source);

// The heights across the middle of the reference, every step_mm from left_mm on, NaN where there is none: what a
// tolerance stores of it.
std::vector<double> middle_section(const HeightCells& reference, const Tolerance& outline, double step_mm);

// Throws UserError, naming `source`, if the tolerance places parts by their edges, its part leaves the view, or it was
// made for another part: the heights across the middle differ from the stored ones by more than kOtherPart mm or 1 % of
// the distance to the plane in more than half of the places.
void check_map_tolerance(const Tolerance& tolerance, const rig::Rig& rig, const HeightCells& reference,
                         const std::string& source);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_TOLERANCE_H
