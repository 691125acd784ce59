// Why columns became no points, counted and in words.
#ifndef SELFPROJ_LIGHT_SECTION_VALIDITY_COUNTS_H
#define SELFPROJ_LIGHT_SECTION_VALIDITY_COUNTS_H

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "selfproj/light_section/profile.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

// How many columns there are of each Validity.
using ValidityCounts = std::array<std::uint64_t, kValidities>;

// Adds columns, each a Validity.
void count_columns(std::span<const std::uint8_t> validity, ValidityCounts& counts);

// Where fewer than half of the columns are valid: how many are, the reasons of the others, the most frequent first, and
// what to do about each, as one line of text. Reasons of less than a tenth of the columns are left out. Empty if half
// or more are valid, or there are no columns. Columns outside the camera's region do not count. The numbers named are
// those of `measure`.
std::string doubt_about_columns(const ValidityCounts& counts, const rig::RigMeasure& measure);

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_VALIDITY_COUNTS_H
