// Tests frequencies, speeds and rings on known samples.
#include "sim/cosim/motion_analysis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/cosim/wave_dispersion.h"
#include "tests/host/light_section/seen_surface.h"

namespace selfproj::test {
namespace {

TEST(FitSine, FindsFrequencyAndAmplitude) {
  for (const double frequency : {2.0, 3.5, 5.013}) {
    std::vector<double> t;
    std::vector<double> y;
    for (int i = 0; i < 280; ++i) {
      t.push_back(1.2 + i * 0.002);
      const double noise = 0.5 * std::sin(i * i * 0.7);
      y.push_back(i % 17 == 0 ? std::nan("")
                              : 420 + 50 * std::sin(2 * std::numbers::pi * frequency * t.back() + 1) + noise);
    }
    const sim::SineFit fit = sim::fit_sine(t, y, 1, 8);
    EXPECT_NEAR(fit.frequency, frequency, 0.01);
    EXPECT_NEAR(fit.amplitude, 50, 0.3);
    EXPECT_NEAR(fit.mean, 420, 0.5);
    EXPECT_NEAR(fit.residual, 0.5 / std::numbers::sqrt2, 0.1);
  }
  EXPECT_TRUE(std::isnan(sim::fit_sine({0, 1}, {1, 2}, 1, 8).frequency));
}

// Clean sines of which 0.284 s were seen: less than a period of each. Noise is that of a centroid.
TEST(FitSine, APartOfAPeriodIsEnough) {
  std::mt19937_64 random(7);
  for (const double frequency : {1.5, 2.2, 2.76, 2.95, 3.12, 3.42, 3.44, 3.52}) {
    for (const double noise : {0.0, frequency > 2 ? 1.0 : 0.1}) {
      std::normal_distribution<double> error(0, 1);
      std::vector<double> t;
      std::vector<std::vector<double>> ys(3);
      for (int i = 0; i < 143; ++i) {
        t.push_back(0.008 + i * 0.002);
        for (std::size_t k = 0; k < ys.size(); ++k) {
          ys[k].push_back(100.0 * static_cast<double>(k) + noise * error(random) +
                          40 * std::sin(2 * std::numbers::pi * frequency * t.back() + 2.1 * static_cast<double>(k)));
        }
      }
      const double most = noise > 0 ? 0.02 : 1e-5;
      EXPECT_NEAR(sim::common_frequency(t, ys, 1, 8), frequency, most * frequency) << noise;
      if (noise == 0) {
        EXPECT_NEAR(sim::fit_sine(t, ys[0], 1, 8).frequency, frequency, most * frequency);
        EXPECT_NEAR(sim::fit_sine(t, ys[0], 1, 8).amplitude, 40, 1e-3);
      }
    }
  }
  EXPECT_TRUE(std::isnan(sim::common_frequency({0, 1}, {{1, 2}}, 1, 8)));
}

TEST(FitLine, FindsSlope) {
  const sim::LineFit fit = sim::fit_line({0, 1, 2, 3}, {5, 7, std::nan(""), 11});
  EXPECT_NEAR(fit.slope, 2, 1e-12);
  EXPECT_NEAR(fit.at_0, 5, 1e-12);
  EXPECT_TRUE(std::isnan(sim::fit_line({1}, {2}).slope));
}

TEST(SlopeBetweenJumps, JumpsDoNotMatter) {
  std::vector<double> t;
  std::vector<double> y;
  for (int i = 0; i < 45; ++i) {
    t.push_back(0.002 * i);
    y.push_back(i == 7 ? std::nan("") : 40 + 350 * t.back() - (i > 20 ? 25 : 0) - (i > 33 ? 25 : 0));
  }
  EXPECT_NEAR(sim::slope_between_jumps(t, y, 0.004, 0.01), 350, 1e-6);
  EXPECT_TRUE(std::isnan(sim::slope_between_jumps({0, 1}, {1, 2}, 2, 3)));
}

// A crest of known radius on a level surface, and a lower one inside it.
TEST(RingMeans, ForemostCrestIsWhereItWasPut) {
  const rig::Rig rig = rig::load_rig("scanner");
  const structured_light::PlaneTriangulation triangulation(rig, 8);
  const images::FloatImage background(512, 512, 520);
  constexpr double kX = -10;
  constexpr double kY = -60;
  const sim::RingMeans rings(triangulation, {kX, kY, -135, 115, -170, 170}, 3, 40);
  for (const double radius : {40.0, 61.3, 95.0}) {
    images::FloatImage depth = background;
    for (std::size_t i = 0; i < depth.values.size(); ++i) {
      const structured_light::Point3f p = triangulation.point(i, 520);
      const double r = std::hypot(static_cast<double>(p.x) - kX, static_cast<double>(p.y) - kY);
      const auto bump = [&](double at) { return std::exp(-(r - at) * (r - at) / 100); };
      depth.values[i] -= static_cast<float>(2 * bump(radius) + 1.2 * bump(radius - 35));
    }
    for (std::size_t i = 0; i < depth.values.size(); i += 97) {
      depth.values[i] -= 300;  // wrong codes
    }
    const std::vector<double> means = rings.means(depth, background, 10);
    EXPECT_NEAR(sim::foremost_crest(rings, means, 0.4), radius, 0.5);
    EXPECT_TRUE(std::isnan(sim::foremost_crest(rings, means, 3)));
  }
}

// Measures depth and speeds of waves that this test computes by formulas of its own.

constexpr sim::Basin kBasin{-130, 120, -150, 160};
constexpr double kLevel = 520;  // z of the water at rest, mm

struct Turning {
  int m, n;
  double omega;  // rad/s
  double mm, phase;
};

double wavenumber(int m, int n) {
  return std::numbers::pi * std::hypot(m / (kBasin.x1 - kBasin.x0), n / (kBasin.y1 - kBasin.y0));
}

// Standing waves of random amplitudes and phases, with lengths from `shortest` to `longest` and frequencies by `omega`.
std::vector<Turning> random_waves(double longest, double shortest, const std::function<double(double k)>& omega,
                                  std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Turning> waves;
  for (int m = 0; m < 12; ++m) {
    for (int n = 0; n < 12; ++n) {
      const double k = wavenumber(m, n);
      const double length = 2 * std::numbers::pi / k;
      if (m + n > 0 && length >= shortest && length <= longest) {
        waves.push_back({m, n, omega(k), 0.05 + 0.2 * share(random), 2 * std::numbers::pi * share(random)});
      }
    }
  }
  return waves;
}

// The waves in 20 depth images of a coarse scanner within 0.3 s. `noise_mm` is the standard deviation of a depth.
sim::BasinWaves seen(const std::vector<Turning>& waves, double noise_mm, std::uint64_t seed) {
  const rig::Rig rig = coarse_scanner(4);
  const structured_light::PlaneTriangulation triangulation(rig, 8);
  const images::FloatImage background(rig.camera.rows, rig.camera.columns, static_cast<float>(kLevel));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, noise_mm);
  sim::BasinWaves measured(kBasin, 60, 1);
  std::vector<std::vector<double>> shapes(waves.size());
  for (std::size_t pixel = 0; pixel < background.values.size(); ++pixel) {
    const structured_light::Point3f p = triangulation.point(pixel, static_cast<float>(kLevel));
    const double x = std::numbers::pi * (static_cast<double>(p.x) - kBasin.x0) / (kBasin.x1 - kBasin.x0);
    const double y = std::numbers::pi * (static_cast<double>(p.y) - kBasin.y0) / (kBasin.y1 - kBasin.y0);
    for (std::size_t w = 0; w < waves.size(); ++w) {
      shapes[w].push_back(waves[w].mm * std::cos(waves[w].m * x) * std::cos(waves[w].n * y));
    }
  }
  for (int i = 0; i < 20; ++i) {
    const double t = 1.44 + 0.016 * i;
    images::FloatImage depth = background;
    std::vector<double> turns;
    for (const Turning& wave : waves) {
      turns.push_back(std::cos(wave.omega * t + wave.phase));
    }
    for (std::size_t pixel = 0; pixel < depth.values.size(); ++pixel) {
      double rise = noise(random);
      for (std::size_t w = 0; w < waves.size(); ++w) {
        rise += shapes[w][pixel] * turns[w];
      }
      depth.values[pixel] = pixel % 101 == 0  ? std::numeric_limits<float>::quiet_NaN()
                            : pixel % 97 == 0 ? static_cast<float>(kLevel) - 90  // a wrong code
                                              : static_cast<float>(kLevel - rise);
    }
    measured.add(t, triangulation, depth, background, 10);
  }
  return measured;
}

double airy(double k, double depth) { return std::sqrt((9806.65 * k + 7.293e4 * k * k * k) * std::tanh(k * depth)); }

TEST(WaveDispersion, DepthComesOut) {
  for (const auto& [depth, seed] : {std::pair(12.0, 5U), {20.0, 6U}, {31.0, 7U}, {45.0, 8U}}) {
    const double wanted = std::sqrt(9806.65 * depth);
    const auto waves = random_waves(
        700, 62, [depth = depth](double k) { return airy(k, depth); }, seed);
    const sim::LongWaves found = sim::WaveDispersion(seen(waves, 0.5, seed + 100)).long_waves();
    EXPECT_GT(found.waves, waves.size() / 2);
    EXPECT_NEAR(found.speed, wanted, 0.02 * wanted) << depth;
    EXPECT_LT(std::abs(found.speed - wanted), 4 * found.deviation + 0.002 * wanted) << depth;
    EXPECT_NEAR(found.depth, depth, 0.04 * depth);
    EXPECT_LT(found.misfit, 1.5) << depth;
  }
}

// Weaker gravity, or a clock that runs too fast, slows down all waves alike. If the waves hardly depend on the depth,
// this would look like another depth.
TEST(WaveDispersion, GravityNeedNotBeTheStandard) {
  for (const double factor : {0.995, 1.005}) {
    const auto waves = random_waves(
        140, 62, [factor](double k) { return std::sqrt(factor) * airy(k, 36); }, 14);
    const sim::LongWaves found = sim::WaveDispersion(seen(waves, 0.1, 15)).long_waves();
    EXPECT_NEAR(found.speed, std::sqrt(9806.65 * 36), 0.02 * found.speed) << factor;
    EXPECT_LT(found.misfit, 1.5) << factor;
  }
}

TEST(WaveDispersion, EachLengthHasItsSpeed) {
  const auto waves = random_waves(
      700, 62, [](double k) { return airy(k, 30); }, 11);
  const sim::WaveDispersion measured(seen(waves, 0.3, 12));
  for (const auto& [longest, shortest] : {std::pair(240.0, 160.0), {160.0, 120.0}, {120.0, 95.0}, {75.0, 60.0}}) {
    const sim::WaveSpeed found = measured.speed(longest, shortest);
    const double k = 2 * std::numbers::pi / found.length;
    EXPECT_GE(found.waves, 3U);
    EXPECT_GT(found.length, shortest);
    EXPECT_LT(found.length, longest);
    EXPECT_NEAR(found.speed, airy(k, 30) / k, 12) << longest;
    EXPECT_LT(found.deviation, 20);
  }
  EXPECT_EQ(measured.speed(3000, 2000).waves, 0U);
  EXPECT_TRUE(std::isnan(measured.speed(3000, 2000).speed));
}

// Waves of all these lengths do not run at one speed on water, and the misfit shows this.
TEST(WaveDispersion, OtherWavesDoNotFit) {
  const auto waves = random_waves(
      700, 62, [](double k) { return 400 * k; }, 21);
  const sim::WaveDispersion measured(seen(waves, 0.3, 22));
  for (const auto& [longest, shortest] : {std::pair(240.0, 160.0), {75.0, 60.0}}) {
    const sim::WaveSpeed found = measured.speed(longest, shortest);
    EXPECT_NEAR(found.speed, 400, 3 * found.deviation + 1);
    EXPECT_LT(found.deviation, 10);
  }
  EXPECT_GT(measured.long_waves().misfit, 5);
}

// The speed of short waves hardly depends on the depth. So the depth stays unknown, and the deviation shows this.
TEST(WaveDispersion, ShortWavesAloneDoNotTellTheDepth) {
  const auto waves = random_waves(
      75, 62, [](double k) { return airy(k, 90); }, 31);
  const sim::LongWaves found = sim::WaveDispersion(seen(waves, 0.5, 32)).long_waves();
  EXPECT_GE(found.waves, 10U);
  EXPECT_FALSE(found.deviation < 0.05 * found.speed);
}

TEST(WaveDispersion, NoiseIsNoWave) {
  const sim::BasinWaves measured = seen({}, 0.5, 41);
  EXPECT_GT(measured.waves().size(), 50U);
  const sim::LongWaves found = sim::WaveDispersion(measured).long_waves();
  EXPECT_LT(found.waves, 10U);
  EXPECT_TRUE(std::isnan(found.speed));
}

TEST(WaveDispersion, AmplitudesAreInMillimetres) {
  const sim::BasinWaves measured = seen({{0, 3, 0, 1.5, 0}, {2, 1, 0, -0.75, 0}}, 0, 51);
  for (const sim::StandingWave& wave : measured.waves()) {
    const double wanted = wave.m == 0 && wave.n == 3 ? 1.5 : wave.m == 2 && wave.n == 1 ? -0.75 : 0;
    EXPECT_NEAR(wave.k, wavenumber(wave.m, wave.n), 1e-12);
    ASSERT_EQ(wave.amplitude.size(), measured.times().size());
    EXPECT_NEAR(wave.amplitude[7], wanted, 0.06) << wave.m << ", " << wave.n;
  }
}

TEST(WaveDispersion, BadBasins) {
  EXPECT_THROW(sim::BasinWaves({0, 0, 0, 1}, 60, 1), std::invalid_argument);
  EXPECT_THROW(sim::BasinWaves(kBasin, 0, 1), std::invalid_argument);
  EXPECT_THROW(sim::BasinWaves(kBasin, 60, 0), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
