// Tests frequencies, speeds and rings on known samples.
#include "sim/cosim/motion_analysis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {
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
    const SineFit fit = fit_sine(t, y, 1, 8);
    EXPECT_NEAR(fit.frequency, frequency, 0.01);
    EXPECT_NEAR(fit.amplitude, 50, 0.3);
    EXPECT_NEAR(fit.mean, 420, 0.5);
    EXPECT_NEAR(fit.residual, 0.5 / std::numbers::sqrt2, 0.1);
  }
  EXPECT_TRUE(std::isnan(fit_sine({0, 1}, {1, 2}, 1, 8).frequency));
}

TEST(FitLine, FindsSlope) {
  const LineFit fit = fit_line({0, 1, 2, 3}, {5, 7, std::nan(""), 11});
  EXPECT_NEAR(fit.slope, 2, 1e-12);
  EXPECT_NEAR(fit.at_0, 5, 1e-12);
  EXPECT_TRUE(std::isnan(fit_line({1}, {2}).slope));
}

TEST(SlopeBetweenJumps, JumpsDoNotMatter) {
  std::vector<double> t;
  std::vector<double> y;
  for (int i = 0; i < 45; ++i) {
    t.push_back(0.002 * i);
    y.push_back(i == 7 ? std::nan("") : 40 + 350 * t.back() - (i > 20 ? 25 : 0) - (i > 33 ? 25 : 0));
  }
  EXPECT_NEAR(slope_between_jumps(t, y, 0.004, 0.01), 350, 1e-6);
  EXPECT_TRUE(std::isnan(slope_between_jumps({0, 1}, {1, 2}, 2, 3)));
}

// A crest of known radius on a level surface, and a lower one inside it.
TEST(RingMeans, ForemostCrestIsWhereItWasPut) {
  const Rig rig = load_rig("scanner");
  const PlaneTriangulation triangulation(rig, 8);
  const FloatImage background(512, 512, 520);
  constexpr double kX = -10;
  constexpr double kY = -60;
  const RingMeans rings(triangulation, {kX, kY, -135, 115, -170, 170}, 3, 40);
  for (const double radius : {40.0, 61.3, 95.0}) {
    FloatImage depth = background;
    for (std::size_t i = 0; i < depth.values.size(); ++i) {
      const Point3f p = triangulation.point(i, 520);
      const double r = std::hypot(static_cast<double>(p.x) - kX, static_cast<double>(p.y) - kY);
      const auto bump = [&](double at) { return std::exp(-(r - at) * (r - at) / 100); };
      depth.values[i] -= static_cast<float>(2 * bump(radius) + 1.2 * bump(radius - 35));
    }
    for (std::size_t i = 0; i < depth.values.size(); i += 97) {
      depth.values[i] -= 300;  // wrong codes
    }
    const std::vector<double> means = rings.means(depth, background, 10);
    EXPECT_NEAR(foremost_crest(rings, means, 0.4), radius, 0.5);
    EXPECT_TRUE(std::isnan(foremost_crest(rings, means, 3)));
  }
}

}  // namespace
}  // namespace selfproj
