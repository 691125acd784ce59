#include "selfproj/structured_light/foreground.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "model/cpu_clones.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {
namespace {

// Enough for the compiler to keep the loop over them and vectorize it.
constexpr std::ptrdiff_t kLanes = 64;
constexpr std::ptrdiff_t kRun = kLanes * 16;  // pixels whose sums are floats: 16 for each lane

// Sums over the pixels of the foreground: of 1, of z - o_z, and of the latter times the ray's slopes.
struct Sums {
  float count[kLanes] = {};
  float z[kLanes] = {};
  float x[kLanes] = {};
  float y[kLanes] = {};
};

// Handles whole lanes only.
SELFPROJ_CLONES void add(const float* __restrict z, const float* __restrict background, const float* __restrict x_per_z,
                         const float* __restrict y_per_z, std::ptrdiff_t count, float origin_z, float least,
                         Sums& sums) {
  Sums s;
  for (std::ptrdiff_t i = 0; i < count; i += kLanes) {
    for (std::ptrdiff_t k = 0; k < kLanes; ++k) {
      const float depth = z[i + k];
      // NaN on either side compares false, and must not enter a product with 0. Masks are used, because a branch, or
      // what the compiler takes for one, would keep it from vectorizing.
      const auto mask =
          static_cast<std::uint32_t>(-static_cast<std::int32_t>(std::abs(depth - background[i + k]) > least));
      const auto distance = std::bit_cast<float>(std::bit_cast<std::uint32_t>(depth - origin_z) & mask);
      s.count[k] += std::bit_cast<float>(std::bit_cast<std::uint32_t>(1.0F) & mask);
      s.z[k] += distance;
      s.x[k] += distance * x_per_z[i + k];
      s.y[k] += distance * y_per_z[i + k];
    }
  }
  sums = s;
}

// `z` if it holds, else NaN. A conditional would keep the compiler from vectorizing.
[[gnu::always_inline]] inline float where(bool holds, float z) {
  constexpr std::uint32_t kNanBits = 0x7FC00000;
  const auto none = static_cast<std::uint32_t>(static_cast<std::int32_t>(holds) - 1);
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(z) | (none & kNanBits));
}

SELFPROJ_CLONES void keep_different(const float* __restrict z, const float* __restrict background, std::ptrdiff_t count,
                                    float least, float* __restrict kept) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    kept[i] = where(std::abs(z[i] - background[i]) > least, z[i]);
  }
}

SELFPROJ_CLONES void keep_steady(const float* __restrict z, const float* __restrict before, std::ptrdiff_t count,
                                 float most, float* __restrict kept) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    kept[i] = where(std::abs(z[i] - before[i]) <= most, kept[i]);
  }
}

// `pitch` is the distance between rows. There is one pixel of margin on all sides.
SELFPROJ_CLONES void keep_supported(const float* __restrict kept, std::ptrdiff_t pitch, std::ptrdiff_t count,
                                    float most, std::int32_t least, float* __restrict out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const float z = kept[i];
    const auto near = [&](std::ptrdiff_t at) { return static_cast<std::int32_t>(std::abs(kept[i + at] - z) <= most); };
    const std::int32_t around = near(-pitch - 1) + near(-pitch) + near(-pitch + 1) + near(-1) + near(1) +
                                near(pitch - 1) + near(pitch) + near(pitch + 1);
    out[i] = where(around >= least, z);
  }
}

}  // namespace

SteadyFilter::SteadyFilter(int rows, int columns, const SteadySettings& settings)
    : rows_(rows),
      columns_(columns),
      settings_(settings),
      on_(std::isfinite(settings.max_change_mm) || settings.min_neighbours > 0) {
  constexpr int kNeighbours = 8;
  if (!(settings.max_change_mm >= 0) || settings.min_neighbours < 0 || settings.min_neighbours > kNeighbours) {
    throw std::invalid_argument("foreground: a setting is out of range");
  }
  if (on_) {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    const auto r = static_cast<std::size_t>(rows);
    const auto c = static_cast<std::size_t>(columns);
    before_.resize(r * c);
    kept_.assign(r * c, kNone);
    steady_.assign((r + 2) * (c + 2), kNone);
  }
}

void SteadyFilter::apply(const float* z, const float* background, float min_mm) {
  const std::ptrdiff_t columns = columns_;
  const std::ptrdiff_t pitch = columns + 2;
  for (std::ptrdiff_t r = 0; r < rows_; ++r) {
    float* const steady = steady_.data() + (r + 1) * pitch + 1;
    keep_different(z + r * columns, background + r * columns, columns, min_mm, steady);
    if (has_before_) {
      keep_steady(z + r * columns, before_.data() + r * columns, columns, settings_.max_change_mm, steady);
    }
  }
  for (std::ptrdiff_t r = 0; r < rows_; ++r) {
    keep_supported(steady_.data() + (r + 1) * pitch + 1, pitch, columns, settings_.max_change_mm,
                   settings_.min_neighbours, kept_.data() + r * columns);
  }
}

void SteadyFilter::remember(const float* z) {
  std::copy_n(z, before_.size(), before_.begin());
  has_before_ = true;
}

Foreground foreground_of(const Triangulation& triangulation, const float* z, const float* background, float min_mm) {
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
    add(z + at, background + at, x_per_z + at, y_per_z + at, run, origin.z, min_mm, sums);
    take(sums);
  }
  for (std::ptrdiff_t i = total / kLanes * kLanes; i < total; ++i) {  // pixels that fill no lanes
    if (std::abs(z[i] - background[i]) > min_mm) {
      const double distance = static_cast<double>(z[i]) - static_cast<double>(origin.z);
      count += 1;
      sum_z += distance;
      sum_x += distance * static_cast<double>(x_per_z[i]);
      sum_y += distance * static_cast<double>(y_per_z[i]);
    }
  }
  if (count == 0) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {0, kNone, kNone, kNone};
  }
  return {static_cast<std::int64_t>(count), static_cast<double>(origin.x) + sum_x / count,
          static_cast<double>(origin.y) + sum_y / count, static_cast<double>(origin.z) + sum_z / count};
}

}  // namespace selfproj::structured_light
