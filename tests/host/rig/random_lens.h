// Random lenses, and OpenCV's lens model written out, against which host/rig/calibration is tested.
#ifndef SELFPROJ_TESTS_HOST_RIG_RANDOM_LENS_H
#define SELFPROJ_TESTS_HOST_RIG_RANDOM_LENS_H

#include <array>
#include <cstddef>
#include <utility>

#include "selfproj/rig/calibration.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// Column and row of the ray (x, y, 1).
inline std::pair<double, double> distorted(const rig::Lens& lens, double x, double y) {
  const auto& k = lens.k;
  const double r2 = x * x + y * y;
  const double q =
      (1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2) / (1 + k[5] * r2 + k[6] * r2 * r2 + k[7] * r2 * r2 * r2);
  return {lens.fx * (x * q + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x)) + lens.cx,
          lens.fy * (y * q + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y) + lens.cy};
}

// A lens for an image of columns x rows, with its centre near the middle; `focal` is in pixels.
inline rig::Lens random_lens(Random& random, double focal, int columns, int rows) {
  rig::Lens lens{focal * uniform(random, 0.95, 1.05),
                 focal,
                 columns * uniform(random, 0.45, 0.55),
                 rows * uniform(random, 0.45, 0.55),
                 {}};
  const std::array<double, 8> reach{0.2, 0.15, 0.003, 0.003, 0.1, 0.05, 0.05, 0.02};
  for (std::size_t i = 0; i < reach.size(); ++i) {
    lens.k[i] = uniform(random, -reach[i], reach[i]);
  }
  return lens;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_RIG_RANDOM_LENS_H
