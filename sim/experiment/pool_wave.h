// Where and when the ring wave of B2 is measured.
#ifndef SELFPROJ_SIM_EXPERIMENT_POOL_WAVE_H
#define SELFPROJ_SIM_EXPERIMENT_POOL_WAVE_H

#include <cstddef>
#include <vector>

#include "host/structured_light/triangulation.h"
#include "sim/experiment/motion_analysis.h"
#include "sim/experiment/wave_dispersion.h"
#include "sim/scene/scanner_scenes.h"

namespace selfproj {

// Rises of the water, mm: no wave is greater, and a crest is at least so great.
inline constexpr double kMostWave = 10;
inline constexpr double kLeastWave = 0.5;

// Seconds after the impact at which the ring has left the splash, and those before it reaches a wall.
inline constexpr double kWaveFrom = 0.08;
inline constexpr double kWaveTo = 0.17;
inline bool is_open_wave(double after_impact) { return after_impact >= kWaveFrom && after_impact <= kWaveTo; }

// Speed of the foremost crest, mm/s, from its distances at the times t, s. A crest fades while the next one grows, so
// that the foremost one jumps back now and then.
inline double crest_speed(const std::vector<double>& t, const std::vector<double>& distance) {
  constexpr double kShort = 0.004;
  constexpr double kLong = 0.01;
  return slope_between_jumps(t, distance, kShort, kLong);
}

// The water, between the walls of the pool.
inline constexpr Basin pool_basin() {
  return {PoolWave::kCentreX - PoolWave::kWidth / 2, PoolWave::kCentreX + PoolWave::kWidth / 2, -PoolWave::kLength / 2,
          PoolWave::kLength / 2};
}

// Rings around the place of the impact, within the pool.
inline RingMeans pool_rings(const Triangulation& triangulation, double x = PoolWave::kImpactX,
                            double y = PoolWave::kImpactY) {
  constexpr double kStep = 3;  // mm
  constexpr std::size_t kRings = 40;
  constexpr Basin kPool = pool_basin();
  return {triangulation, {x, y, kPool.x0, kPool.x1, kPool.y0, kPool.y1}, kStep, kRings};
}

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_POOL_WAVE_H
