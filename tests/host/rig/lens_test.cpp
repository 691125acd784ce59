// Compares lenses with OpenCV's model written out.

#include <gtest/gtest.h>

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "host/rig/calibration.h"
#include "tests/host/rig/random_lens.h"
#include "tests/support/random_cases.h"

namespace selfproj {
namespace {

using test::distorted;
using test::Random;
using test::random_lens;
using test::uniform;

TEST(Lens, PixelAndRayAreEachOthersReverse) {
  for (const std::uint64_t seed : test::seeds(300)) {
    SCOPED_TRACE(test::how_to_repeat(seed));
    Random random(seed);
    const Lens lens = random_lens(random, 1500, 1280, 800);
    const double x = uniform(random, -0.4, 0.4);
    const double y = uniform(random, -0.25, 0.25);
    const auto [column, row] = distorted(lens, x, y);
    cv::Matx22d derivative;
    const cv::Vec2d pixel = lens.pixel({x, y}, derivative);
    EXPECT_NEAR(pixel[0], column, 1e-9);
    EXPECT_NEAR(pixel[1], row, 1e-9);
    constexpr double kStep = 1e-6;
    EXPECT_NEAR(derivative(0, 0), (distorted(lens, x + kStep, y).first - column) / kStep, 0.1);
    EXPECT_NEAR(derivative(0, 1), (distorted(lens, x, y + kStep).first - column) / kStep, 0.1);
    EXPECT_NEAR(derivative(1, 0), (distorted(lens, x + kStep, y).second - row) / kStep, 0.1);
    EXPECT_NEAR(derivative(1, 1), (distorted(lens, x, y + kStep).second - row) / kStep, 0.1);
    const auto ray = lens.ray(pixel);
    ASSERT_TRUE(ray.has_value());
    EXPECT_NEAR((*ray)[0], x, 1e-9);
    EXPECT_NEAR((*ray)[1], y, 1e-9);
  }
}

TEST(Lens, HasNoRayBeyondItsFold) {
  const Lens lens{1000, 1000, 500, 500, {-0.5, 0, 0, 0, 0, 0, 0, 0}};  // r (1 - r²/2) is 0.544 at most
  EXPECT_TRUE(lens.ray({1000, 500}).has_value());
  EXPECT_FALSE(lens.ray({1100, 500}).has_value());
}

}  // namespace
}  // namespace selfproj
