#include "host/gray/moved.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "host/gray/triangulation.h"
#include "model/cpu_clones.h"

namespace selfproj {
namespace {

// So many that the compiler keeps the loop over them, and vectorizes it.
constexpr std::ptrdiff_t kLanes = 64;
constexpr std::ptrdiff_t kRun = kLanes * 16;  // pixels whose sums are floats: 16 a lane

// Sums over the pixels that moved: of ones, of z - o_z, and of the same times the ray's slopes.
struct Sums {
  float count[kLanes] = {};
  float z[kLanes] = {};
  float x[kLanes] = {};
  float y[kLanes] = {};
};

// Whole lanes only.
SELFPROJ_CLONES void add(const float* __restrict z, const float* __restrict background, const float* __restrict x_per_z,
                         const float* __restrict y_per_z, std::ptrdiff_t count, float origin_z, float least,
                         Sums& sums) {
  Sums s;
  for (std::ptrdiff_t i = 0; i < count; i += kLanes) {
    for (std::ptrdiff_t k = 0; k < kLanes; ++k) {
      const float depth = z[i + k];
      // NaN on either side compares false, and must not meet a product with 0. Masks: a branch, or what the compiler
      // takes for one, would keep it from vectorizing.
      const auto mask =
          static_cast<std::uint32_t>(-static_cast<std::int32_t>(std::abs(depth - background[i + k]) > least));
      const auto way = std::bit_cast<float>(std::bit_cast<std::uint32_t>(depth - origin_z) & mask);
      s.count[k] += std::bit_cast<float>(std::bit_cast<std::uint32_t>(1.0F) & mask);
      s.z[k] += way;
      s.x[k] += way * x_per_z[i + k];
      s.y[k] += way * y_per_z[i + k];
    }
  }
  sums = s;
}

}  // namespace

Moved moved(const Triangulation& triangulation, const float* z, const float* background, float least_mm) {
  const auto total = static_cast<std::ptrdiff_t>(triangulation.pixels());
  const float* const x_per_z = triangulation.x_per_z();
  const float* const y_per_z = triangulation.y_per_z();
  const Point3f& origin = triangulation.origin();
  double count = 0;
  double sum_x = 0;
  double sum_y = 0;
  double sum_z = 0;
  const auto take = [&](const Sums& sums) {
    for (std::ptrdiff_t k = 0; k < kLanes; ++k) {
      count += static_cast<double>(sums.count[k]);
      sum_x += static_cast<double>(sums.x[k]);
      sum_y += static_cast<double>(sums.y[k]);
      sum_z += static_cast<double>(sums.z[k]);
    }
  };
  Sums sums;
  std::ptrdiff_t at = 0;
  for (; at + kLanes <= total; at += kRun) {
    const std::ptrdiff_t run = std::min(kRun, (total - at) / kLanes * kLanes);
    add(z + at, background + at, x_per_z + at, y_per_z + at, run, origin.z, least_mm, sums);
    take(sums);
  }
  for (std::ptrdiff_t i = total / kLanes * kLanes; i < total; ++i) {  // what fills no lanes
    if (std::abs(z[i] - background[i]) > least_mm) {
      const double way = static_cast<double>(z[i]) - static_cast<double>(origin.z);
      count += 1;
      sum_z += way;
      sum_x += way * static_cast<double>(x_per_z[i]);
      sum_y += way * static_cast<double>(y_per_z[i]);
    }
  }
  if (count == 0) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {0, kNone, kNone, kNone};
  }
  return {static_cast<std::int64_t>(count), static_cast<double>(origin.x) + sum_x / count,
          static_cast<double>(origin.y) + sum_y / count, static_cast<double>(origin.z) + sum_z / count};
}

}  // namespace selfproj
