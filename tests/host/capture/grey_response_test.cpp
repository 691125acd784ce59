// Tests the curve of a projector that follows from images of its greys.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/capture/grey_curve.h"
#include "selfproj/files/user_error.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kSide = 40;

// Images of a wall that is brighter to the right, with noise of one grey value, under light = (grey / 255)^gamma.
std::vector<images::Image> images_of(const std::vector<int>& greys, double gamma, double brightest, Random& random) {
  std::vector<images::Image> images;
  for (const int grey : greys) {
    images::Image image{kSide, kSide, std::vector<std::uint8_t>(kSide * kSide)};
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const double wall = brightest * static_cast<double>(1 + i % kSide) / kSide;
      const double seen = 12 + wall * std::pow(grey / 255.0, gamma) + random.between(-100, 100) / 100.0;
      image.pixels[i] = static_cast<std::uint8_t>(std::clamp(std::lround(seen), 0L, 255L));
    }
    images.push_back(image);
  }
  return images;
}

TEST(GreyResponse, FindsTheGammaOfPixelsThatAreLitAndNotSaturated) {
  const std::vector<int> greys = capture::grey_levels(18);
  EXPECT_EQ(greys.front(), 0);
  EXPECT_EQ(greys[1], 15);
  EXPECT_EQ(greys.back(), 255);
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const double gamma = random.between(80, 280) / 100.0;
    const capture::GreyResponse response =
        capture::grey_response(greys, images_of(greys, gamma, 400, random), "camera:x");
    EXPECT_LT(response.pixels, static_cast<std::size_t>(kSide * kSide) * 6 / 10);  // the right half is saturated
    EXPECT_NEAR(response.gamma, gamma, 0.02 * gamma);
    for (const capture::GreyCurve::Point& point : response.curve.points) {
      EXPECT_NEAR(point.light / response.curve.points.back().light, std::pow(point.grey / 255, gamma), 0.02);
    }
  }
}

TEST(GreyResponse, RefusesWhatTellsNothing) {
  const std::vector<int> greys = capture::grey_levels(5);
  Random random(1);
  EXPECT_THROW(capture::grey_response(greys, images_of(greys, 1, 20, random), "camera:x"), UserError);
  EXPECT_THROW(capture::grey_response(greys, images_of(greys, 1, 20'000, random), "camera:x"), UserError);
  std::vector<images::Image> falls = images_of(greys, 1, 200, random);
  std::swap(falls[1], falls[3]);
  EXPECT_THROW(capture::grey_response(greys, falls, "camera:x"), UserError);
}

}  // namespace
}  // namespace selfproj::test
