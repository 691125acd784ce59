// Measures motion in the depth images of experiments B1 to B3: frequencies, amplitudes, speeds.
#ifndef SELFPROJ_SIM_COSIM_MOTION_ANALYSIS_H
#define SELFPROJ_SIM_COSIM_MOTION_ANALYSIS_H

#include <cstddef>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/structured_light/foreground.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/cosim/wave_dispersion.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {

// What counts as moved: a pixel at least this far (mm) from the background that fulfils the conditions of the filter.
// B1 finds these settings the best.
inline constexpr double kMovedMm = 10;
inline constexpr structured_light::SteadySettings kSteady{10, 6};

// y = mean + amplitude sin(2 pi frequency t + phase), by least squares.
struct SineFit {
  double frequency = 0;  // Hz; NaN if there are too few values
  double mean = 0;
  double amplitude = 0;
  double residual = 0;  // RMS of the residuals of the fit
};

// Finds the frequency in low..high, also where less than a period was seen: by a grid whose steps are a twentieth of
// what the time tells apart, and between its best points to 1e-6 of it. Ignores NaN. At least 8 values are needed. With
// less than half a period, small errors of y make large ones of the frequency.
SineFit fit_sine(const std::vector<double>& t, const std::vector<double>& y, double low, double high);

// The one frequency, as above, of several quantities that were seen at the same times, such as the coordinates of a
// point that circles. NaN if one of them has too few values.
double common_frequency(const std::vector<double>& t, const std::vector<std::vector<double>>& ys, double low,
                        double high);

// y = at_0 + slope t, by least squares; NaN unless there are two different t. Ignores NaN.
struct LineFit {
  double at_0 = 0;
  double slope = 0;
};
LineFit fit_line(const std::vector<double>& t, const std::vector<double>& y);

// The median of the slopes between all pairs of values that are `least` to `most` apart in t, NaN without any (Theil
// and Sen). Where y jumps now and then, from one crest to the next, it is the slope between the jumps.
double slope_between_jumps(const std::vector<double>& t, const std::vector<double>& y, double least, double most);

// The rise of the surface over a background, in mm towards the camera, averaged over rings around a point.
class RingMeans {
 public:
  // `count` rings, each `step` mm wide, around (x, y). Only points within the rectangle count.
  struct Place {
    double x, y;
    double x0, x1, y0, y1;
  };
  RingMeans(const structured_light::Triangulation& triangulation, const Place& place, double step, std::size_t count);

  // The means of background - depth, at the positions of the background's points. Pixels count if they have both depths
  // and the two differ by no more than `most` mm (more is a wrong code). Each ring's mean is smoothed twice with a
  // quarter of both neighbours'. NaN for rings of fewer than 20 pixels and beside them.
  [[nodiscard]] std::vector<double> means(const images::FloatImage& depth, const images::FloatImage& background,
                                          double most) const;

  [[nodiscard]] double radius(std::size_t ring) const { return (static_cast<double>(ring) + 0.5) * step_; }

 private:
  const structured_light::Triangulation& triangulation_;
  Place place_;
  double step_;
  std::size_t count_;
};

// The radius of the foremost crest: from outside, the first local maximum that is at least `least` and at least four
// fifths of the greatest. A parabola through it and its neighbours gives its place. NaN if there is none.
double foremost_crest(const RingMeans& rings, const std::vector<double>& means, double least);

// The places and times at which the ring wave of B2 is measured.

// Limits of the water's rise, mm: any wave is at most kMaxWave high, and a crest counts if it is at least kMinWave
// high.
inline constexpr double kMaxWave = 10;
inline constexpr double kMinWave = 0.5;

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
inline RingMeans pool_rings(const structured_light::Triangulation& triangulation, double x = PoolWave::kImpactX,
                            double y = PoolWave::kImpactY) {
  constexpr double kStep = 3;  // mm
  constexpr std::size_t kRings = 40;
  constexpr Basin kPool = pool_basin();
  return {triangulation, {x, y, kPool.x0, kPool.x1, kPool.y0, kPool.y1}, kStep, kRings};
}

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_COSIM_MOTION_ANALYSIS_H
