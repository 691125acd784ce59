// Measures how fast waves of each length run on water in a basin, from depth images alone. The depth of the water and
// the speed of long waves follow from these speeds.
#ifndef SELFPROJ_SIM_COSIM_WAVE_DISPERSION_H
#define SELFPROJ_SIM_COSIM_WAVE_DISPERSION_H

#include <cstddef>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::sim {

// Water between four vertical walls, mm.
struct Basin {
  double x0, x1, y0, y1;
};

// Walls reflect waves, so the surface of the water is always a sum of standing waves:
//
//     cos(m pi (x - x0)/(x1 - x0)) cos(n pi (y - y0)/(y1 - y0)),   k^2 = (m pi/(x1 - x0))^2 + (n pi/(y1 - y0))^2
//
// Each oscillates at its own frequency, wherever the wave came from. The discrete cosine transform of the heights gives
// their amplitudes.
struct StandingWave {
  int m = 0, n = 0;               // half waves along x and y
  double k = 0;                   // rad/mm
  std::vector<double> amplitude;  // mm, at the times of BasinWaves
};

class BasinWaves {
 public:
  // Measures waves down to the length `shortest` (mm). Each amplitude comes from the mean of `images` depth images. If
  // the bits of a code are taken one after another, this should be the number of depth images in a cycle of the
  // patterns. Throws std::invalid_argument unless the sides, `shortest` and `images` are > 0.
  BasinWaves(const Basin& basin, double shortest, std::size_t images);

  // Takes the depth image of time t (s), and that of the water at rest. A pixel counts if its point lies in the basin
  // and its two depths differ by no more than `most` mm. A greater difference means a wrong code.
  void add(double t, const structured_light::Triangulation& triangulation, const images::FloatImage& depth,
           const images::FloatImage& background, double most);

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

// A standing wave that is stronger than the noise: an oscillation at one frequency explains more than three quarters of
// its sum of squares.
struct ObservedWave {
  StandingWave wave;
  double noise = 0;          // variance that its frequency does not explain, but at least the waves' median, mm²
  double energy = 0;         // sum of squares that this frequency explains, divided by the noise
  std::vector<double> rest;  // sum of squares left at each of a range of phase speeds, divided by the noise
};

// The phase speed of waves of similar length, without any theory of water. It is the speed that fits these waves best
// if each of them oscillates at k times this speed (rad/s).
struct WaveSpeed {
  std::size_t waves = 0;
  double length = 0;     // mm, from the mean k of its waves, weighted by their energy
  double speed = 0;      // phase speed, mm/s
  double deviation = 0;  // standard deviation; NaN for fewer than 3 waves
};

// The depth of the water that fits the measured waves best, by omega^2 = f (g k + tension k^3) tanh(k depth). The
// factor f, which may differ from 1 by up to 0.8 %, is fitted together with the depth. It allows for gravity, which
// differs by 0.5 % from place to place, and for small errors of the camera's clock and of the basin's sides. The speed
// of waves shorter than twice the depth hardly depends on the depth. So without the factor, such a small difference
// would look like another depth. The speed of long waves is sqrt(g depth).
struct LongWaves {
  std::size_t waves = 0;
  double depth = 0;      // mm
  double speed = 0;      // mm/s
  double deviation = 0;  // standard deviation of the speed, the greater of two: from leaving out a tenth of the waves
                         // at a time, and from the curve of the sum of squares
  // The mean over the waves of the mean square that the theory leaves, divided by the wave's noise (ObservedWave). It
  // is about 1 if the theory holds, and can be a little less, because the noise is at least the waves' median.
  double misfit = 0;
};

class WaveDispersion {
 public:
  explicit WaveDispersion(const BasinWaves& measured);

  // Returns the speed of the waves with lengths from `shortest` to `longest`, mm. If none of them is stronger than the
  // noise, all members but `waves` are NaN.
  [[nodiscard]] WaveSpeed speed(double longest, double shortest) const;

  // If fewer than 10 waves are stronger than the noise, or if the best depth is not between 3 and 300 mm, all members
  // but `waves` are NaN.
  [[nodiscard]] LongWaves long_waves() const;

 private:
  std::vector<double> times_;
  std::vector<ObservedWave> observed_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_COSIM_WAVE_DISPERSION_H
