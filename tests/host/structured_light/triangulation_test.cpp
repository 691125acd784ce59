// Depth from codes against (4.7) solved in double precision, and against the pinholes of the rig.

#include "host/structured_light/triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "host/rig/calibration_file.h"
#include "host/rig/geometry.h"
#include "host/rig/lens.h"
#include "host/rig/rig.h"
#include "host/structured_light/lens_triangulation.h"
#include "host/structured_light/moved.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/support/random_cases.h"

namespace selfproj {
namespace {

using test::Point3;
using test::Random;

constexpr std::uint16_t kMeasurable = 0x8000;

double uniform(Random& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random.between(0, 1 << 30)) / (1 << 30);
}

// Row and column of pixel i.
std::pair<double, double> place_of(std::size_t i, int columns) {
  const auto at = std::div(static_cast<long>(i), static_cast<long>(columns));
  return {static_cast<double>(at.quot), static_cast<double>(at.rem)};
}

// The three linear equations of (4.7) for pixel (column, row) and C, by Cramer's rule.
std::optional<Point3> solve(const DepthMatrices& m, double column, double row, double c) {
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
double camera_depth(const DepthMatrices& m, const Point3& p) {
  return m.camera(2, 0) * p.x + m.camera(2, 1) * p.y + m.camera(2, 2) * p.z + m.camera(2, 3);
}
double projector_depth_of(const DepthMatrices& m, const Point3& p) {
  return m.projector(1, 0) * p.x + m.projector(1, 1) * p.y + m.projector(1, 2) * p.z + m.projector(1, 3);
}

// Whether z at the pixel is valid by the definition of DepthLimits, and z. `margin` is how far it is from every limit,
// as a share of it.
struct Expected {
  bool valid = false;
  double z = 0;
  double margin = 0;
};
Expected expected_depth(const DepthMatrices& m, const DepthLimits& limits, double codes_per_line, double column,
                        double row, double c, int rows, int columns, int bits) {
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
std::size_t expect_depths(const PlaneTriangulation& triangulation, const DepthMatrices& m, const DepthLimits& limits,
                          double codes_per_line, Random& random) {
  const std::size_t count = triangulation.pixels();
  std::vector<std::uint16_t> codes(count);
  for (std::uint16_t& code : codes) {
    code = static_cast<std::uint16_t>(random.between(0, (1 << triangulation.bits()) - 1) |
                                      (random.chance(90) ? kMeasurable : 0));
  }
  std::vector<float> z(count, -1);
  std::vector<PointState> states(count);
  triangulation.depth(codes.data(), z.data());
  triangulation.explain(codes.data(), z.data(), states.data());
  std::size_t valid = 0;
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(states[i] == PointState::valid, !std::isnan(z[i]));
    if ((codes[i] & kMeasurable) == 0) {
      EXPECT_EQ(states[i], PointState::not_measurable);
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
      const Point3f point = triangulation.point(i, z[i]);
      const auto exact = solve(m, column, row, c);
      EXPECT_NEAR(static_cast<double>(point.x), exact->x, 2e-3);
      EXPECT_NEAR(static_cast<double>(point.y), exact->y, 2e-3);
    }
  }
  return valid;
}

Rig random_rig(Random& random) {
  Rig rig = load_rig("scanner");
  rig.camera.rows = random.between(1, 60);
  rig.camera.columns = random.between(1, 60);
  rig.camera.pixel_pitch_mm = 0.01 * 512 / std::max(rig.camera.rows, 20);  // about the same field
  rig.camera.focal_length_mm = uniform(random, 5, 8);
  rig.projector.tilt_rad = uniform(random, 0.1, 0.4);
  rig.projector.x_mm = uniform(random, 60, 200);
  rig.projector.z_mm = uniform(random, -100, 320);
  rig.projector.center_xp_mm = uniform(random, -2, 2);
  rig.measure.max_z_per_line_mm = uniform(random, 0.7, 8);
  return rig;
}

TEST(DepthMatrices, AreThePinholesOfTheRig) {
  for (const std::uint64_t seed : test::seeds(50)) {
    SCOPED_TRACE(test::how_to_repeat(seed));
    Random random(seed);
    const Rig rig = random_rig(random);
    const int bits = random.between(1, 12);
    const DepthMatrices m = depth_matrices(rig, bits);
    const Point3 p{uniform(random, -100, 100), uniform(random, -100, 100), uniform(random, 400, 600)};
    const test::Pixel camera = test::camera_sees(rig.camera, p);
    const test::Pixel projector = test::projector_lights(rig.projector, p);
    const cv::Vec4d q(p.x, p.y, p.z, 1);
    const cv::Vec3d c = m.camera * q;
    const cv::Vec2d d = m.projector * q;
    EXPECT_NEAR(c[0] / c[2], camera.column, 1e-9);
    EXPECT_NEAR(c[1] / c[2], camera.row, 1e-9);
    EXPECT_NEAR(d[0] / d[1], (projector.row + 0.5) * std::ldexp(1.0, bits) / rig.projector.lines, 1e-9);
    EXPECT_GT(d[1], 0);
  }
}

TEST(PlaneTriangulation, SolvesTheEquationsOnRigs) {
  std::size_t valid = 0;
  for (const std::uint64_t seed : test::seeds(60)) {
    SCOPED_TRACE(test::how_to_repeat(seed));
    Random random(seed);
    const Rig rig = random_rig(random);
    const int bits = random.between(4, 12);
    DepthLimits limits;
    limits.min_z_mm = uniform(random, 0, 420);
    limits.max_z_mm = uniform(random, 600, 2000);
    const PlaneTriangulation triangulation(rig, bits, limits);
    limits.max_z_per_line_mm = rig.measure.max_z_per_line_mm;
    valid += expect_depths(triangulation, depth_matrices(rig, bits), limits,
                           std::ldexp(1.0, bits) / rig.projector.lines, random);
  }
  EXPECT_GT(valid, 0U);
}

// A camera turned about all axes, elsewhere than at the origin, and matrices in another scale: each pixel has terms of
// its own.
TEST(PlaneTriangulation, SolvesTheEquationsInAnyWorld) {
  std::size_t valid = 0;
  for (const std::uint64_t seed : test::seeds(60)) {
    SCOPED_TRACE(test::how_to_repeat(seed));
    Random random(seed);
    const Rig rig = random_rig(random);
    const int bits = random.between(4, 12);
    DepthMatrices m = depth_matrices(rig, bits);
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
    DepthLimits limits;
    limits.max_z_per_line_mm = uniform(random, 2, 8);
    const double codes_per_line = std::ldexp(1.0, bits) / rig.projector.lines;
    const PlaneTriangulation triangulation(rig.camera.rows, rig.camera.columns, bits, m, limits, codes_per_line);
    valid += expect_depths(triangulation, m, limits, codes_per_line, random);
  }
  EXPECT_GT(valid, 0U);
}

// The depth of a plane whose codes are those that its points are lit with: off by half a code at most, and not to one
// side.
TEST(PlaneTriangulation, CodeStandsForTheMiddleOfItsCell) {
  const Rig rig = load_rig("scanner");
  constexpr int kBits = 8;
  const PlaneTriangulation triangulation(rig, kBits);
  std::vector<std::uint16_t> codes(triangulation.pixels());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const double row = place_of(i, 512).first;
    const double x = rig.plane_z_mm * rig.camera.pixel_pitch_mm * (row - 255.5) / rig.camera.focal_length_mm;
    const double line = test::projector_lights(rig.projector, {x, 0, rig.plane_z_mm}).row;
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
  const Rig rig = load_rig("scanner");
  const PlaneTriangulation triangulation(rig, 8);
  std::vector<std::uint16_t> codes(triangulation.pixels());
  int first_lost = 0;
  for (int row = 0; row < 512; ++row) {
    const double x = rig.plane_z_mm * tan_alpha(rig.camera, row + 1);
    const double line = test::projector_lights(rig.projector, {x, 0, rig.plane_z_mm}).row;
    const int code = std::clamp(static_cast<int>(std::floor((line + 0.5) / 3)), 0, 255);
    std::fill_n(codes.begin() + static_cast<std::ptrdiff_t>(row) * 512, 512,
                static_cast<std::uint16_t>(code | kMeasurable));
  }
  std::vector<float> z(codes.size());
  std::vector<PointState> states(codes.size());
  triangulation.depth(codes.data(), z.data());
  triangulation.explain(codes.data(), z.data(), states.data());
  while (first_lost < 512 && states[static_cast<std::size_t>(first_lost) * 512] == PointState::valid) {
    ++first_lost;
  }
  EXPECT_NEAR(first_lost, 408, 6);
  EXPECT_EQ(states[static_cast<std::size_t>(first_lost) * 512], PointState::too_coarse);
}

TEST(PlaneTriangulation, RefusesWhatIsOutOfRange) {
  const Rig rig = load_rig("scanner");
  DepthMatrices m = depth_matrices(rig, 8);
  EXPECT_THROW(PlaneTriangulation(0, 4, 8, m, {}), std::invalid_argument);
  EXPECT_THROW(PlaneTriangulation(4, 4, 0, m, {}), std::invalid_argument);
  EXPECT_THROW(PlaneTriangulation(4, 4, 13, m, {}), std::invalid_argument);
  EXPECT_THROW(PlaneTriangulation(4, 4, 8, m, {}, 0), std::invalid_argument);
  m.camera(2, 2) = -1;  // looks the other way
  EXPECT_THROW(PlaneTriangulation(4, 4, 8, m, {}), std::invalid_argument);
  m.camera = cv::Matx34d::zeros();
  EXPECT_THROW(PlaneTriangulation(4, 4, 8, m, {}), std::invalid_argument);
}

// ------------------------------------------------------------------ lenses

// OpenCV's distortion, written out.
std::pair<double, double> distorted(const Lens& lens, double x, double y) {
  const auto& k = lens.k;
  const double r2 = x * x + y * y;
  const double q =
      (1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2) / (1 + k[5] * r2 + k[6] * r2 * r2 + k[7] * r2 * r2 * r2);
  return {lens.fx * (x * q + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x)) + lens.cx,
          lens.fy * (y * q + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y) + lens.cy};
}

Lens random_lens(Random& random, double focal, int columns, int rows) {
  Lens lens{focal * uniform(random, 0.95, 1.05),
            focal,
            columns * uniform(random, 0.45, 0.55),
            rows * uniform(random, 0.45, 0.55),
            {}};
  const std::array<double, 8> reach{0.2, 0.15, 0.003, 0.003, 0.1, 0.05, 0.05, 0.02};
  for (std::size_t i = 0; i < reach.size(); ++i) {
    lens.k[i] = uniform(random, -reach[i], reach[i]);
  }
  return lens;
}

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

Calibration random_calibration(Random& random, int columns, int rows, bool distortion) {
  Calibration c;
  c.camera = random_lens(random, 1.3 * std::max(columns, rows), columns, rows);
  c.projector = random_lens(random, 1600, 1280, 800);
  if (!distortion) {
    c.camera.k = {};
    c.projector.k = {};
  }
  const double a = uniform(random, 0.2, 0.4);
  const double b = uniform(random, -0.05, 0.05);
  c.rotation = cv::Matx33d(std::cos(a), 0, std::sin(a), 0, 1, 0, -std::sin(a), 0, std::cos(a)) *
               cv::Matx33d(std::cos(b), -std::sin(b), 0, std::sin(b), std::cos(b), 0, 0, 0, 1);
  c.translation = {uniform(random, -220, -160), uniform(random, -20, 20), uniform(random, -60, 0)};
  return c;
}

// The ray of a camera pixel, found by bisection-free search: Newton's method with numerical derivatives.
Point3 camera_ray(const Lens& lens, double column, double row) {
  double x = (column - lens.cx) / lens.fx;
  double y = (row - lens.cy) / lens.fy;
  for (int i = 0; i < 200; ++i) {
    const auto [c, r] = distorted(lens, x, y);
    x -= (c - column) / lens.fx * 0.9;
    y -= (r - row) / lens.fy * 0.9;
  }
  return {x, y, 1};
}

std::pair<double, double> projector_sees(const Calibration& c, const Point3& ray, double z) {
  const auto& r = c.rotation;
  const double x = z * (r(0, 0) * ray.x + r(0, 1) * ray.y + r(0, 2)) + c.translation[0];
  const double y = z * (r(1, 0) * ray.x + r(1, 1) * ray.y + r(1, 2)) + c.translation[1];
  const double d = z * (r(2, 0) * ray.x + r(2, 1) * ray.y + r(2, 2)) + c.translation[2];
  return distorted(c.projector, x / d, y / d);
}

TEST(LensTriangulation, FindsTheDepthOfTheColumnOrOfBothCodes) {
  constexpr int kBits = 11;
  for (const std::uint64_t seed : test::seeds(30)) {
    SCOPED_TRACE(test::how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(8, 24);
    const int columns = random.between(8, 32);
    const Calibration calibration = random_calibration(random, columns, rows, true);
    const LensSettings settings{rows, columns, kBits, kBits, 0, 0, 3, {}};
    const LensTriangulation triangulation(calibration, settings);
    std::vector<std::uint16_t> codes(triangulation.pixels()), row_codes(codes.size());
    std::vector<double> truth(codes.size());
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const auto [at_row, at_column] = place_of(i, columns);
      const Point3 ray = camera_ray(calibration.camera, at_column, at_row);
      truth[i] = uniform(random, 550, 850);
      const auto [column, row] = projector_sees(calibration, ray, truth[i]);
      if (std::abs(column - 640) < 640 && std::abs(row - 400) < 400) {
        codes[i] = static_cast<std::uint16_t>(static_cast<int>(std::lround(column)) | kMeasurable);
        row_codes[i] = static_cast<std::uint16_t>(static_cast<int>(std::lround(row)) | kMeasurable);
      }
    }
    std::vector<float> z(codes.size()), both(codes.size()), residual(codes.size());
    std::vector<PointState> states(codes.size());
    triangulation.depth(codes.data(), z.data());
    triangulation.depth_of_both(codes.data(), row_codes.data(), both.data(), states.data(), residual.data());
    std::size_t valid = 0;
    for (std::size_t i = 0; i < codes.size(); ++i) {
      if (codes[i] == 0) {
        ASSERT_TRUE(std::isnan(z[i]));
        ASSERT_EQ(states[i], PointState::not_measurable);
        continue;
      }
      ++valid;
      const auto [at_row, at_column] = place_of(i, columns);
      const Point3 ray = camera_ray(calibration.camera, at_column, at_row);
      // One axis: the point's image lies on the column.
      ASSERT_FALSE(std::isnan(z[i]));
      EXPECT_NEAR(projector_sees(calibration, ray, static_cast<double>(z[i])).first, codes[i] & 0xFFF, 1e-3);
      EXPECT_NEAR(static_cast<double>(z[i]), truth[i], 2.5);  // half a column
      // Both: no depth nearby has its image nearer to the pixel of the codes.
      ASSERT_EQ(states[i], PointState::valid);
      const auto way = [&](double depth) {
        const auto [column, row] = projector_sees(calibration, ray, depth);
        return std::hypot(column - (codes[i] & 0xFFF), row - (row_codes[i] & 0xFFF));
      };
      const auto best = static_cast<double>(both[i]);
      EXPECT_NEAR(way(best), static_cast<double>(residual[i]), 1e-3);
      EXPECT_LE(way(best), way(best + 0.05) + 1e-6);
      EXPECT_LE(way(best), way(best - 0.05) + 1e-6);
      EXPECT_LT(residual[i], 0.71F);
    }
    EXPECT_GT(valid, 0U);
  }
}

TEST(LensTriangulation, WithoutDistortionIsThePlanes) {
  for (const std::uint64_t seed : test::seeds(20)) {
    SCOPED_TRACE(test::how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(2, 24);
    const int columns = random.between(2, 32);
    const Calibration c = random_calibration(random, columns, rows, false);
    const int bits = random.between(6, 11);
    const double lines = 1280;
    DepthLimits limits{300, 2000, uniform(random, 1, 20)};
    const LensTriangulation lens(c, {rows, columns, bits, 0, lines, 0, 3, limits});
    const cv::Matx34d camera(c.camera.fx, 0, c.camera.cx, 0, 0, c.camera.fy, c.camera.cy, 0, 0, 0, 1, 0);
    cv::Matx<double, 2, 4> projector;
    const double scale = std::ldexp(1.0, bits) / lines;
    for (int k = 0; k < 4; ++k) {
      const auto part = [&](int row) { return k < 3 ? c.rotation(row, k) : c.translation[row]; };
      projector(0, k) = scale * (c.projector.fx * part(0) + (c.projector.cx + 0.5) * part(2));
      projector(1, k) = part(2);
    }
    const PlaneTriangulation planes(rows, columns, bits, {camera, projector}, limits, scale);
    std::vector<std::uint16_t> codes(lens.pixels());
    for (std::uint16_t& code : codes) {
      code = static_cast<std::uint16_t>(random.between(0, (1 << bits) - 1) | kMeasurable);
    }
    std::vector<float> a(codes.size()), b(codes.size());
    lens.depth(codes.data(), a.data());
    planes.depth(codes.data(), b.data());
    std::size_t differing = 0;
    for (std::size_t i = 0; i < codes.size(); ++i) {
      if (std::isnan(a[i]) != std::isnan(b[i])) {
        ++differing;  // on a limit
      } else if (!std::isnan(a[i])) {
        EXPECT_NEAR(static_cast<double>(a[i]), static_cast<double>(b[i]), 2e-3);
      }
    }
    EXPECT_LE(differing, codes.size() / 100 + 1);
  }
}

// Codes of projector columns that do not exist, and codes of the two axes that do not belong together.
TEST(LensTriangulation, LeavesOutWhatBelongsToNoPoint) {
  Random random(1);
  Calibration c = random_calibration(random, 16, 16, true);
  c.projector_columns = 1280;
  c.projector_rows = 800;
  const LensTriangulation triangulation(c, {16, 16, 11, 11, 0, 0, 3, {}});
  const Point3 ray = camera_ray(c.camera, 8, 8);
  const auto [column, row] = projector_sees(c, ray, 700);
  const std::size_t pixel = 8 * 16 + 8;
  const auto word = [](double value) {
    return static_cast<std::uint16_t>(static_cast<int>(std::lround(value)) | kMeasurable);
  };
  const auto state_of = [&](std::uint16_t code, std::uint16_t row_code) {
    std::vector<std::uint16_t> codes(256), row_codes(256);
    codes[pixel] = code;
    row_codes[pixel] = row_code;
    std::vector<float> z(256);
    std::vector<PointState> states(256);
    triangulation.depth_of_both(codes.data(), row_codes.data(), z.data(), states.data(), nullptr);
    EXPECT_EQ(std::isnan(z[pixel]), states[pixel] != PointState::valid);
    return states[pixel];
  };
  EXPECT_EQ(state_of(word(column), word(row)), PointState::valid);
  EXPECT_EQ(state_of(word(column), word(row + 20)), PointState::off_line);
  EXPECT_EQ(state_of(word(1280), word(row)), PointState::no_line);
  EXPECT_EQ(state_of(word(column), word(800)), PointState::no_line);
  EXPECT_EQ(state_of(word(column), static_cast<std::uint16_t>(row)), PointState::not_measurable);
}

// ------------------------------------------------------------------ what moved

TEST(Moved, IsTheCentroidOfTheDifferingPoints) {
  for (const std::uint64_t seed : test::seeds(60)) {
    SCOPED_TRACE(test::how_to_repeat(seed));
    Random random(seed);
    const Rig rig = random_rig(random);
    const PlaneTriangulation triangulation(rig, 8);
    const auto some = [&](float base) {
      std::vector<float> z(triangulation.pixels());
      for (float& value : z) {
        value = random.chance(20) ? std::nanf("") : base + static_cast<float>(uniform(random, -8, 8));
      }
      return z;
    };
    const std::vector<float> z = some(500);
    const std::vector<float> background = some(500);
    const auto least = static_cast<float>(uniform(random, 0, 20));
    double count = 0;
    double x = 0;
    double y = 0;
    double depth = 0;
    for (std::size_t i = 0; i < z.size(); ++i) {
      if (!std::isnan(z[i]) && !std::isnan(background[i]) && std::abs(z[i] - background[i]) > least) {
        const Point3f point = triangulation.point(i, z[i]);
        count += 1;
        x += static_cast<double>(point.x);
        y += static_cast<double>(point.y);
        depth += static_cast<double>(point.z);
      }
    }
    const Moved found = moved(triangulation, z.data(), background.data(), least);
    ASSERT_EQ(found.pixels, static_cast<std::int64_t>(count));
    if (count == 0) {
      EXPECT_TRUE(std::isnan(found.x) && std::isnan(found.y) && std::isnan(found.z));
    } else {
      EXPECT_NEAR(found.x, x / count, 1e-3);
      EXPECT_NEAR(found.y, y / count, 1e-3);
      EXPECT_NEAR(found.z, depth / count, 1e-3);
    }
  }
}

// Against its definition, written out pixel by pixel.
TEST(Moved, SteadyFilterKeepsWhatStaysAndHasNeighbours) {
  for (const std::uint64_t seed : test::seeds(40)) {
    SCOPED_TRACE(test::how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(1, 20);
    const int columns = random.between(1, 90);
    SteadySettings settings;
    settings.least_neighbours = random.between(0, 8);
    if (random.chance(70)) {
      settings.most_change_mm = static_cast<float>(uniform(random, 0, 12));
    }
    SteadyFilter filter(rows, columns, settings);
    EXPECT_EQ(filter.is_on(), settings.least_neighbours > 0 || std::isfinite(settings.most_change_mm));
    if (!filter.is_on()) {
      continue;
    }
    const auto some = [&] {
      std::vector<float> z(static_cast<std::size_t>(rows * columns));
      for (float& value : z) {
        value = random.chance(5) ? std::nanf("") : 500 + static_cast<float>(uniform(random, -6, 6));
      }
      return z;
    };
    const std::vector<float> background = some();
    constexpr float kLeast = 2;
    std::vector<float> before;
    for (int image = 0; image < 3; ++image) {
      const std::vector<float> z = some();
      const auto steady = [&](int r, int c) {
        if (r < 0 || c < 0 || r >= rows || c >= columns) {
          return false;
        }
        const auto i = static_cast<std::size_t>(r * columns + c);
        const bool stays = before.empty() || std::abs(z[i] - before[i]) <= settings.most_change_mm;
        return std::abs(z[i] - background[i]) > kLeast && stays;
      };
      filter.take(z.data(), background.data(), kLeast);
      for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) {
          const auto i = static_cast<std::size_t>(r * columns + c);
          int around = 0;
          for (int dr = -1; dr <= 1; ++dr) {
            for (int dc = -1; dc <= 1; ++dc) {
              const bool other = (dr != 0 || dc != 0) && steady(r + dr, c + dc);
              around += other && std::abs(z[static_cast<std::size_t>((r + dr) * columns + c + dc)] - z[i]) <=
                                     settings.most_change_mm
                            ? 1
                            : 0;
            }
          }
          const bool kept = steady(r, c) && around >= settings.least_neighbours;
          ASSERT_EQ(std::isnan(filter.kept()[i]), !kept) << r << ", " << c;
          ASSERT_TRUE(!kept || filter.kept()[i] == z[i]);
        }
      }
      filter.remember(z.data());
      before = z;
    }
  }
  EXPECT_THROW(SteadyFilter(4, 4, {-1, 0}), std::invalid_argument);
  EXPECT_THROW(SteadyFilter(4, 4, {1, 9}), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj
