// What the kernels of profiles have in common.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_STRIP_MOMENTS_H
#define SELFPROJ_HOST_LIGHT_SECTION_STRIP_MOMENTS_H

#include <array>
#include <cstdint>

#include "host/light_section/profile.h"

namespace selfproj {

// The kernels process this many columns at a time, in steps that each keep to one width of numbers. The intermediate
// results, 3 KiB, stay in the first-level cache beside the tables and the profile. With 512 columns they did not.
inline constexpr int kStrip = 128;

struct StripMoments {
  alignas(64) std::array<std::int32_t, kStrip> m0;
  alignas(64) std::array<std::int32_t, kStrip> m1;
  alignas(64) std::array<std::int32_t, kStrip> n;
};

// Which lines count.
struct LineRules {
  float rows;
  std::int32_t min_lit;
  std::int32_t max_lit;
};

constexpr std::int32_t code(Validity validity) { return static_cast<std::int32_t>(validity); }

// The validity of a column with centroid c, where `found` is what triangulation says.
[[gnu::always_inline]] inline std::int32_t validity_of(float c, std::int32_t m0, std::int32_t n,
                                                       std::int32_t has_reference, std::int32_t found,
                                                       const LineRules& rules) {
  std::int32_t s = has_reference != 0 ? found : code(Validity::no_reference);
  s = line_is_cut_off(c, static_cast<float>(n), rules.rows) ? code(Validity::cut_off) : s;
  s = n > rules.max_lit ? code(Validity::too_wide) : s;
  s = n < rules.min_lit ? code(Validity::too_few) : s;
  s = n == 0 ? code(Validity::unlit) : s;
  s = m0 == 0 ? code(Validity::unlit) : s;
  return s;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_STRIP_MOMENTS_H
