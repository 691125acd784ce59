// Compares depth from codes with (4.7) solved in double precision, and with the pinholes of the rig.

#include "selfproj/structured_light/triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

#include "host/rig/geometry.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/host/structured_light/random_rig.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The three linear equations of (4.7) for pixel (column, row) and C, by Cramer's rule.
std::optional<Point3> solve(const rig::DepthMatrices& m, double column, double row, double c) {
  std::array<std::array<double, 4>, 3> e{};
  for (int k = 0; k < 4; ++k) {
    const auto i = static_cast<std::size_t>(k);
    e[0][i] = m.camera(0, k) - column * m.camera(2, k);
    e[1][i] = m.camera(1, k) - row * m.camera(2, k);
    e[2][i] = m.projector(0, k) - c * m.projector(1, k);
  }
  const auto determinant = [&e](std::size_t i, std::size_t j, std::size_t k) {
    return e[0][i] * (e[1][j] * e[2][k] - e[1][k] * e[2][j]) - e[0][j] * (e[1][i] * e[2][k] - e[1][k] * e[2][i]) +
           e[0][k] * (e[1][i] * e[2][j] - e[1][j] * e[2][i]);
  };
  const double d = determinant(0, 1, 2);
  if (d == 0) {
    return std::nullopt;
  }
  return Point3{-determinant(3, 1, 2) / d, -determinant(0, 3, 2) / d, -determinant(0, 1, 3) / d};
}

// H of (4.7) at a point.
double camera_depth(const rig::DepthMatrices& m, const Point3& p) {
  return m.camera(2, 0) * p.x + m.camera(2, 1) * p.y + m.camera(2, 2) * p.z + m.camera(2, 3);
}
double projector_depth_of(const rig::DepthMatrices& m, const Point3& p) {
  return m.projector(1, 0) * p.x + m.projector(1, 1) * p.y + m.projector(1, 2) * p.z + m.projector(1, 3);
}

// Whether z at the pixel is valid by the definition of DepthLimits, and z. `margin` is how far it is from every limit,
// as a share of it.
struct Expected {
  bool valid = false;
  double z = 0;
  double margin = 0;
};
Expected expected_depth(const rig::DepthMatrices& m, const structured_light::DepthLimits& limits, double codes_per_line,
                        double column, double row, double c, int rows, int columns, int bits) {
  const auto at = solve(m, column, row, c);
  const auto beside = solve(m, column, row, c + 1e-4);
  // Whether z falls or grows with C in the middle of the image.
  const auto a = solve(m, 0.5 * (columns - 1), 0.5 * (rows - 1), std::ldexp(0.5, bits));
  const auto b = solve(m, 0.5 * (columns - 1), 0.5 * (rows - 1), std::ldexp(0.5, bits) + 1e-4);
  if (!at || !beside || !a || !b) {
    return {};
  }
  const double slope = (beside->z - at->z) / 1e-4 * codes_per_line;
  const bool same_way = (slope > 0) == (b->z > a->z);
  Expected result;
  result.z = at->z;
  result.valid = camera_depth(m, *at) > 0 && projector_depth_of(m, *at) > 0 && same_way &&
                 std::abs(slope) < limits.max_z_per_line_mm && at->z > limits.min_z_mm && at->z < limits.max_z_mm;
  result.margin = std::min({std::abs(std::abs(slope) / limits.max_z_per_line_mm - 1),
                            std::abs(at->z / std::max(limits.min_z_mm, 1.0) - 1), std::abs(at->z / limits.max_z_mm - 1),
                            std::abs(projector_depth_of(m, *at)) / 100});
  return result;
}

// Returns how many pixels were valid.
std::size_t expect_depths(const structured_light::PlaneTriangulation& triangulation, const rig::DepthMatrices& m,
                          const structured_light::DepthLimits& limits, double codes_per_line, Random& random) {
  const std::size_t count = triangulation.pixels();
  std::vector<std::uint16_t> codes(count);
  for (std::uint16_t& code : codes) {
    code = static_cast<std::uint16_t>(random.between(0, (1 << triangulation.bits()) - 1) |
                                      (random.chance(90) ? kMeasurable : 0));
  }
  std::vector<float> z(count, -1);
  std::vector<structured_light::PointState> states(count);
  triangulation.depth(codes.data(), z.data());
  triangulation.explain(codes.data(), z.data(), states.data());
  std::size_t valid = 0;
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(states[i] == structured_light::PointState::valid, !std::isnan(z[i]));
    if ((codes[i] & kMeasurable) == 0) {
      EXPECT_EQ(states[i], structured_light::PointState::not_measurable);
      continue;
    }
    const auto [row, column] = place_of(i, triangulation.columns());
    const double c = (codes[i] & 0xFFF) + 0.5;
    const Expected expected = expected_depth(m, limits, codes_per_line, column, row, c, triangulation.rows(),
                                             triangulation.columns(), triangulation.bits());
    if (expected.margin < 1e-3) {
      continue;  // floats may fall on either side of a limit
    }
    EXPECT_EQ(!std::isnan(z[i]), expected.valid) << "pixel " << i << ", z " << z[i] << ", expected " << expected.z;
    if (expected.valid) {
      ++valid;
      EXPECT_NEAR(static_cast<double>(z[i]), expected.z, 2e-3) << "pixel " << i;
      const structured_light::Point3f point = triangulation.point(i, z[i]);
      const auto exact = solve(m, column, row, c);
      EXPECT_NEAR(static_cast<double>(point.x), exact->x, 2e-3);
      EXPECT_NEAR(static_cast<double>(point.y), exact->y, 2e-3);
    }
  }
  return valid;
}

TEST(DepthMatrices, AreThePinholesOfTheRig) {
  for (const std::uint64_t seed : seeds(50)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const rig::Rig rig = random_rig(random);
    const int bits = random.between(1, 12);
    const rig::DepthMatrices m = rig::depth_matrices(rig, bits);
    const Point3 p{uniform(random, -100, 100), uniform(random, -100, 100), uniform(random, 400, 600)};
    const Pixel camera = camera_sees(rig.camera, p);
    const Pixel projector = projector_lights(rig.projector, p);
    const cv::Vec4d q(p.x, p.y, p.z, 1);
    const cv::Vec3d c = m.camera * q;
    const cv::Vec2d d = m.projector * q;
    EXPECT_NEAR(c[0] / c[2], camera.column, 1e-9);
    EXPECT_NEAR(c[1] / c[2], camera.row, 1e-9);
    // No code is narrower than a line.
    EXPECT_NEAR(d[0] / d[1], (projector.row + 0.5) * std::min(1.0, std::ldexp(1.0, bits) / rig.projector.lines), 1e-9);
    EXPECT_GT(d[1], 0);
  }
}

TEST(PlaneTriangulation, SolvesTheEquationsOnRigs) {
  std::size_t valid = 0;
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const rig::Rig rig = random_rig(random);
    const int bits = random.between(4, 12);
    structured_light::DepthLimits limits;
    limits.min_z_mm = uniform(random, 0, 420);
    limits.max_z_mm = uniform(random, 600, 2000);
    const structured_light::PlaneTriangulation triangulation(rig, bits, limits);
    limits.max_z_per_line_mm = rig.measure.max_z_per_line_mm;
    valid += expect_depths(triangulation, rig::depth_matrices(rig, bits), limits,
                           std::min(1.0, std::ldexp(1.0, bits) / rig.projector.lines), random);
  }
  EXPECT_GT(valid, 0U);
}

// A camera turned about all axes, elsewhere than at the origin, and matrices in another scale: each pixel has terms of
// its own.
TEST(PlaneTriangulation, SolvesTheEquationsInAnyWorld) {
  std::size_t valid = 0;
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const rig::Rig rig = random_rig(random);
    const int bits = random.between(4, 12);
    rig::DepthMatrices m = rig::depth_matrices(rig, bits);
    const double a = uniform(random, -0.3, 0.3);
    const double b = uniform(random, -0.2, 0.2);
    const cv::Matx33d turn = cv::Matx33d(std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1) *
                             cv::Matx33d(1, 0, 0, 0, std::cos(b), -std::sin(b), 0, std::sin(b), std::cos(b));
    cv::Matx44d world = cv::Matx44d::eye();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        world(r, c) = turn(r, c);
      }
      world(r, 3) = uniform(random, -50, 50);
    }
    m.camera = uniform(random, 0.1, 10) * (m.camera * world);
    m.projector = uniform(random, 0.1, 10) * m.projector;
    structured_light::DepthLimits limits;
    limits.max_z_per_line_mm = uniform(random, 2, 8);
    const double codes_per_line = std::ldexp(1.0, bits) / rig.projector.lines;
    const structured_light::PlaneTriangulation triangulation(rig.camera.rows, rig.camera.columns, bits, m, limits,
                                                             codes_per_line);
    valid += expect_depths(triangulation, m, limits, codes_per_line, random);
  }
  EXPECT_GT(valid, 0U);
}

// The depth of a plane from the codes that light its points: off by half a code at most, and without a bias.
TEST(PlaneTriangulation, CodeStandsForTheMiddleOfItsCell) {
  const rig::Rig rig = rig::load_rig("scanner");
  constexpr int kBits = 8;
  const structured_light::PlaneTriangulation triangulation(rig, kBits);
  std::vector<std::uint16_t> codes(triangulation.pixels());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const double row = place_of(i, 512).first;
    const double x = rig.plane_z_mm * rig.camera.pixel_pitch_mm * (row - 255.5) / rig.camera.focal_length_mm;
    const double line = projector_lights(rig.projector, {x, 0, rig.plane_z_mm}).row;
    const double code = std::floor((line + 0.5) * 256 / rig.projector.lines);
    codes[i] = code >= 0 && code < 256 ? static_cast<std::uint16_t>(static_cast<int>(code) | kMeasurable) : 0;
  }
  std::vector<float> z(codes.size());
  triangulation.depth(codes.data(), z.data());
  double sum = 0;
  double worst = 0;
  int count = 0;
  for (std::size_t i = 100 * 512; i < 400 * 512; ++i) {
    ASSERT_FALSE(std::isnan(z[i])) << i;
    const double error = static_cast<double>(z[i]) - rig.plane_z_mm;
    sum += error;
    worst = std::max(worst, std::abs(error));
    ++count;
  }
  EXPECT_LT(std::abs(sum / count), 0.2);  // without the half: 2 mm
  EXPECT_LT(worst, 8);                    // half a code of 3 lines at 5 mm
  EXPECT_GT(worst, 1);
}

// Section 1 of the method: on rig B the limit removes about the rows from 408 on, x > 150 mm.
TEST(PlaneTriangulation, RigBLosesTheRowsFromAbout408On) {
  const rig::Rig rig = rig::load_rig("scanner");
  const structured_light::PlaneTriangulation triangulation(rig, 8);
  std::vector<std::uint16_t> codes(triangulation.pixels());
  int first_lost = 0;
  for (int row = 0; row < 512; ++row) {
    const double x = rig.plane_z_mm * rig::tan_alpha(rig.camera, row + 1);
    const double line = projector_lights(rig.projector, {x, 0, rig.plane_z_mm}).row;
    const int code = std::clamp(static_cast<int>(std::floor((line + 0.5) / 3)), 0, 255);
    std::fill_n(codes.begin() + static_cast<std::ptrdiff_t>(row) * 512, 512,
                static_cast<std::uint16_t>(code | kMeasurable));
  }
  std::vector<float> z(codes.size());
  std::vector<structured_light::PointState> states(codes.size());
  triangulation.depth(codes.data(), z.data());
  triangulation.explain(codes.data(), z.data(), states.data());
  while (first_lost < 512 &&
         states[static_cast<std::size_t>(first_lost) * 512] == structured_light::PointState::valid) {
    ++first_lost;
  }
  EXPECT_NEAR(first_lost, 408, 6);
  EXPECT_EQ(states[static_cast<std::size_t>(first_lost) * 512], structured_light::PointState::too_coarse);
}

TEST(PlaneTriangulation, RefusesWhatIsOutOfRange) {
  const rig::Rig rig = rig::load_rig("scanner");
  rig::DepthMatrices m = rig::depth_matrices(rig, 8);
  EXPECT_THROW(structured_light::PlaneTriangulation(0, 4, 8, m, {}), std::invalid_argument);
  EXPECT_THROW(structured_light::PlaneTriangulation(4, 4, 0, m, {}), std::invalid_argument);
  EXPECT_THROW(structured_light::PlaneTriangulation(4, 4, 13, m, {}), std::invalid_argument);
  EXPECT_THROW(structured_light::PlaneTriangulation(4, 4, 8, m, {}, 0), std::invalid_argument);
  m.camera(2, 2) = -1;  // looks the other way
  EXPECT_THROW(structured_light::PlaneTriangulation(4, 4, 8, m, {}), std::invalid_argument);
  m.camera = cv::Matx34d::zeros();
  EXPECT_THROW(structured_light::PlaneTriangulation(4, 4, 8, m, {}), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
