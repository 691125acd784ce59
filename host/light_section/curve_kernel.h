// Profiles from the curves of columns (column_curves.h), for rigs that are more than pinholes.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_CURVE_KERNEL_H
#define SELFPROJ_HOST_LIGHT_SECTION_CURVE_KERNEL_H

#include <cstdint>

#include "host/light_section/column_curves.h"
#include "host/light_section/profile.h"
#include "host/light_section/strip_moments.h"
#include "model/column_moments.h"
#include "model/column_runs.h"

namespace selfproj {

// What DifferentialProfiler::profile does, for all columns.
void profile_by_curves(const ColumnCurves& curves, const LineRules& rules, Select select, Mode mode,
                       const std::uint8_t* payload, const ProfileView& out);
void profile_by_curves(const ColumnCurves& curves, const LineRules& rules, const RunsView& runs,
                       const ProfileView& out);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_CURVE_KERNEL_H
