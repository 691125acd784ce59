// The reference as a map of a part has it: what is across the belt, and where heights can be compared.
#ifndef SELFPROJ_HOST_PRODUCTION_PART_REFERENCE_H
#define SELFPROJ_HOST_PRODUCTION_PART_REFERENCE_H

#include <utility>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// What the reference of the light section is like across the belt: places and heights above the plane, mm, by place.
// Columns without a reference are left out; `gap` says after which points one was.
struct SectionReference {
  std::vector<double> across_mm;
  std::vector<double> height_mm;

  // The height at a place, on the straight line between the neighbouring points; NaN where these are further apart than
  // `widest_mm`, or steeper than a wall (kSteepest): heights there say more about the place than about the part.
  [[nodiscard]] double at(double across_mm, double widest_mm) const;

  // Where at() has no height between neighbouring points, walls and gaps, and kBesideWalls camera pixels beside: there
  // the pattern of the rig jumps, wherever the part lies. The straight line of a laser jumps nowhere.
  [[nodiscard]] std::vector<std::pair<double, double>> jumps(const rig::Rig& rig, double widest_mm) const;
};

// Asks the profiler itself where its reference lies, by moments that are exactly those of the reference. It holds for
// every kind of rig, therefore.
SectionReference section_of(const rig::Rig& rig, const light_section::ReferenceProfile& reference,
                            const light_section::DifferentialProfiler& profiler);

// The heights on the rig's grid without those at walls, which say more about the place than about the part: where the
// three cells to a side rise by more than kSteepest, and kBesideWalls camera pixels beside.
images::FloatImage without_steep_places(const images::FloatImage& heights, const rig::Rig& rig);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_PART_REFERENCE_H
