// The places and times at which the ring wave of B2 is measured.
#ifndef SELFPROJ_SIM_COSIM_POOL_WAVE_H
#define SELFPROJ_SIM_COSIM_POOL_WAVE_H

#include <cstddef>
#include <vector>

#include "host/structured_light/triangulation.h"
#include "sim/cosim/motion_analysis.h"
#include "sim/cosim/wave_dispersion.h"
#include "sim/scene/scanner_scenes.h"

namespace selfproj {

// Limits of the water's rise, mm: any wave is at most kMostWave high, and a crest counts if it is at least kLeastWave
// high.
inline constexpr double kMostWave = 10;
inline constexpr double kLeastWave = 0.5;

// Times after the impact, s: at kWaveFrom the ring has left the splash, and until kWaveTo it does not reach a wall.
inline constexpr double kWaveFrom = 0.08;
inline constexpr double kWaveTo = 0.17;
inline bool is_open_wave(double after_impact) { return after_impact >= kWaveFrom && after_impact <= kWaveTo; }

// Returns the speed of the foremost crest in mm/s, from its distances (mm) at the times t (s). From time to time the
// foremost crest jumps back, because a crest fades while the next one grows.
inline double crest_speed(const std::vector<double>& t, const std::vector<double>& distance) {
  constexpr double kShort = 0.004;
  constexpr double kLong = 0.01;
  return slope_between_jumps(t, distance, kShort, kLong);
}

// The walls of the pool.
inline constexpr Basin pool_basin() {
  return {PoolWave::kCentreX - PoolWave::kWidth / 2, PoolWave::kCentreX + PoolWave::kWidth / 2, -PoolWave::kLength / 2,
          PoolWave::kLength / 2};
}

// Rings around the place of the impact (x, y), limited to the pool.
inline RingMeans pool_rings(const Triangulation& triangulation, double x = PoolWave::kImpactX,
                            double y = PoolWave::kImpactY) {
  constexpr double kStep = 3;  // mm
  constexpr std::size_t kRings = 40;
  constexpr Basin kPool = pool_basin();
  return {triangulation, {x, y, kPool.x0, kPool.x1, kPool.y0, kPool.y1}, kStep, kRings};
}

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_POOL_WAVE_H
