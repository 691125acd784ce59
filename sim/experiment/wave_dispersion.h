// How fast waves of each length run on water in a basin, and what depth and speed of long waves follow: from measured
// depth images alone.
#ifndef SELFPROJ_SIM_EXPERIMENT_WAVE_DISPERSION_H
#define SELFPROJ_SIM_EXPERIMENT_WAVE_DISPERSION_H

#include <cstddef>
#include <vector>

#include "host/io/float_image.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

// Water between four vertical walls, mm.
struct Basin {
  double x0, x1, y0, y1;
};

// Walls reflect waves, so that everything on the water is a sum of standing waves
//
//     cos(m pi (x - x0)/(x1 - x0)) cos(n pi (y - y0)/(y1 - y0)),   k^2 = (m pi/(x1 - x0))^2 + (n pi/(y1 - y0))^2
//
// of which each turns at its own frequency, from wherever the wave came. Their amplitudes are the discrete cosine
// transform of the heights.
struct StandingWave {
  int m = 0, n = 0;               // half waves along x and y
  double k = 0;                   // rad/mm
  std::vector<double> amplitude;  // mm, at the times of BasinWaves
};

class BasinWaves {
 public:
  // Waves down to the length `shortest` (mm). Each time is a mean over so many depth images, which is a whole cycle of
  // the patterns if the bits of a code are not of one time. Throws std::invalid_argument unless all are > 0.
  BasinWaves(const Basin& basin, double shortest, std::size_t images);

  // Takes a depth image of the time t (s), and that of the water at rest. Pixels count whose point lies in the basin,
  // and whose two depths differ by no more than `most` mm (more is a wrong code).
  void add(double t, const Triangulation& triangulation, const FloatImage& depth, const FloatImage& background,
           double most);

  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  [[nodiscard]] const std::vector<StandingWave>& waves() const { return waves_; }

 private:
  void transform();

  Basin basin_;
  std::size_t images_;
  int down_, across_;  // cells along x and along y
  std::vector<double> sums_, pixels_;
  std::size_t taken_ = 0;
  double time_sum_ = 0;
  std::vector<double> times_;
  std::vector<StandingWave> waves_;
};

// Clean water at 20 °C (72.8 mN/m, 998 kg/m³) under standard gravity.
inline constexpr double kStandardGravity = 9806.65;  // mm/s²
inline constexpr double kWaterTension = 7.293e4;     // surface tension by density, mm³/s²

// A standing wave that stands out of the noise: a turn at one frequency explains at least three quarters of it.
struct HeardWave {
  StandingWave wave;
  double noise = 0;          // variance of what is left of it at its own frequency, at least that of most waves, mm²
  double energy = 0;         // sum of squares that this frequency explains, by the noise
  std::vector<double> rest;  // sums of squares, by the noise, at each of a range of phase speeds
};

// What waves of similar length have in common, without any theory of water: the speed at which each of them, turning at
// k times this speed, comes nearest to what was measured.
struct WaveSpeed {
  std::size_t waves = 0;
  double length = 0;     // mm, in the mean of the waves that are in it, by their energy
  double speed = 0;      // of phases, mm/s
  double deviation = 0;  // standard deviation; NaN for fewer than 3 waves
};

// The depth of the water at which its waves turn as they were measured, by omega^2 = (g k + tension k^3) tanh(k depth),
// and the speed of long waves that follows, sqrt(g depth).
struct LongWaves {
  std::size_t waves = 0;
  double depth = 0;      // mm
  double speed = 0;      // mm/s
  double deviation = 0;  // standard deviation of the speed: by leaving out a tenth of the waves at a time, or by the
                         // curve of the sum of squares, whichever is greater
  // The sum of squares that the theory leaves, by that which is left if each wave may turn at a frequency of its own;
  // about 1 if the theory holds.
  double misfit = 0;
};

class WaveDispersion {
 public:
  explicit WaveDispersion(const BasinWaves& measured);

  // `longest` and `shortest` bound the lengths, mm. All but `waves` is NaN if no wave is heard.
  [[nodiscard]] WaveSpeed speed(double longest, double shortest) const;

  // All but `waves` is NaN if fewer than 10 waves are heard, or if no depth from 3 to 300 mm is the best.
  [[nodiscard]] LongWaves long_waves() const;

 private:
  std::vector<double> times_;
  std::vector<HeardWave> heard_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_WAVE_DISPERSION_H
