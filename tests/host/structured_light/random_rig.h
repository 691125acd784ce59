// Random rigs, and helpers for tests of codes and depth.
#ifndef SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_RANDOM_RIG_H
#define SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_RANDOM_RIG_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "selfproj/rig/rig.h"
#include "tests/host/rig/random_lens.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// Bit 15 of a code word.
inline constexpr std::uint16_t kMeasurable = 0x8000;

// Row and column of pixel i.
inline std::pair<double, double> place_of(std::size_t i, int columns) {
  const auto at = std::div(static_cast<long>(i), static_cast<long>(columns));
  return {static_cast<double>(at.quot), static_cast<double>(at.rem)};
}

// Rig B with another image size, focal length, projector and limit. The camera sees about the same field.
inline rig::Rig random_rig(Random& random) {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows = random.between(1, 60);
  rig.camera.columns = random.between(1, 60);
  rig.camera.pixel_pitch_mm = 0.01 * 512 / std::max(rig.camera.rows, 20);
  rig.camera.focal_length_mm = uniform(random, 5, 8);
  rig.projector.tilt_rad = uniform(random, 0.1, 0.4);
  rig.projector.x_mm = uniform(random, 60, 200);
  rig.projector.z_mm = uniform(random, -100, 320);
  rig.projector.center_xp_mm = uniform(random, -2, 2);
  rig.measure.max_z_per_line_mm = uniform(random, 0.7, 8);
  return rig;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_RANDOM_RIG_H
