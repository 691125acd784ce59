// Tests depth by the full lens model: projects points back through distortion written out, and compares with pinholes.

#include "selfproj/structured_light/lens_triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "selfproj/rig/calibration.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/structured_light/triangulation.h"
#include "tests/host/rig/random_lens.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/host/structured_light/random_rig.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

rig::Calibration random_calibration(Random& random, int columns, int rows) {
  rig::Calibration c;
  c.camera = random_lens(random, 1.3 * std::max(columns, rows), columns, rows);
  c.projector = random_lens(random, 1600, 1280, 800);
  const double a = uniform(random, 0.2, 0.4);
  const double b = uniform(random, -0.05, 0.05);
  c.rotation = cv::Matx33d(std::cos(a), 0, std::sin(a), 0, 1, 0, -std::sin(a), 0, std::cos(a)) *
               cv::Matx33d(std::cos(b), -std::sin(b), 0, std::sin(b), std::cos(b), 0, 0, 0, 1);
  c.translation = {uniform(random, -220, -160), uniform(random, -20, 20), uniform(random, -60, 0)};
  return c;
}

rig::Calibration without_distortion(rig::Calibration calibration) {
  calibration.camera.k = {};
  calibration.projector.k = {};
  return calibration;
}

// The ray of a camera pixel, by fixed-point iteration: distortion is small against the focal length.
Point3 camera_ray(const rig::Lens& lens, double column, double row) {
  double x = (column - lens.cx) / lens.fx;
  double y = (row - lens.cy) / lens.fy;
  for (int i = 0; i < 200; ++i) {
    const auto [c, r] = distorted(lens, x, y);
    x -= (c - column) / lens.fx * 0.9;
    y -= (r - row) / lens.fy * 0.9;
  }
  return {x, y, 1};
}

std::pair<double, double> projector_sees(const rig::Calibration& c, const Point3& ray, double z) {
  const auto& r = c.rotation;
  const double x = z * (r(0, 0) * ray.x + r(0, 1) * ray.y + r(0, 2)) + c.translation[0];
  const double y = z * (r(1, 0) * ray.x + r(1, 1) * ray.y + r(1, 2)) + c.translation[1];
  const double d = z * (r(2, 0) * ray.x + r(2, 1) * ray.y + r(2, 2)) + c.translation[2];
  return distorted(c.projector, x / d, y / d);
}

// For each camera pixel the codes of a point at a random depth on its ray, 0 where the projector of 1280 x 800 does not
// reach it.
struct RandomPoints {
  std::vector<std::uint16_t> codes;  // of the columns
  std::vector<std::uint16_t> row_codes;
  std::vector<double> truth;  // z
};

RandomPoints random_points(Random& random, const rig::Calibration& calibration, std::size_t pixels, int columns) {
  RandomPoints points{std::vector<std::uint16_t>(pixels), std::vector<std::uint16_t>(pixels),
                      std::vector<double>(pixels)};
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto [at_row, at_column] = place_of(i, columns);
    points.truth[i] = uniform(random, 550, 850);
    const auto [column, row] =
        projector_sees(calibration, camera_ray(calibration.camera, at_column, at_row), points.truth[i]);
    if (std::abs(column - 640) < 640 && std::abs(row - 400) < 400) {
      points.codes[i] = static_cast<std::uint16_t>(static_cast<int>(std::lround(column)) | kMeasurable);
      points.row_codes[i] = static_cast<std::uint16_t>(static_cast<int>(std::lround(row)) | kMeasurable);
    }
  }
  return points;
}

TEST(LensTriangulation, FindsTheDepthOfTheColumnOrOfBothCodes) {
  constexpr int kBits = 11;
  for (const std::uint64_t seed : seeds(30)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(8, 24);
    const int columns = random.between(8, 32);
    const rig::Calibration calibration = random_calibration(random, columns, rows);
    const structured_light::LensSettings settings{
        .rows = rows, .columns = columns, .bits = kBits, .row_bits = kBits, .limits = {}};
    const structured_light::LensTriangulation triangulation(calibration, settings);
    const RandomPoints points = random_points(random, calibration, triangulation.pixels(), columns);
    const std::vector<std::uint16_t>& codes = points.codes;
    const std::vector<std::uint16_t>& row_codes = points.row_codes;
    const std::vector<double>& truth = points.truth;
    std::vector<float> z(codes.size()), both(codes.size()), residual(codes.size());
    std::vector<structured_light::PointState> states(codes.size());
    triangulation.depth(codes.data(), z.data());
    triangulation.depth_of_both(codes.data(), row_codes.data(), both.data(), states.data(), residual.data());
    std::size_t valid = 0;
    for (std::size_t i = 0; i < codes.size(); ++i) {
      if (codes[i] == 0) {
        ASSERT_TRUE(std::isnan(z[i]));
        ASSERT_EQ(states[i], structured_light::PointState::not_measurable);
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
      ASSERT_EQ(states[i], structured_light::PointState::valid);
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

// With both codes the projector may lie to any side: where it is above or below the camera, its columns say nothing of
// the depth, or the opposite left and right in the image.
TEST(LensTriangulation, BothCodesNeedNoSide) {
  constexpr int kBits = 11;
  for (const std::uint64_t seed : seeds(30)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(8, 24);
    const int columns = random.between(8, 32);
    rig::Calibration calibration = random_calibration(random, columns, rows);
    const double a = (random.chance(50) ? 1 : -1) * uniform(random, 0.2, 0.4);  // down or up
    const double b = uniform(random, -0.05, 0.05);
    calibration.rotation = cv::Matx33d(1, 0, 0, 0, std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a)) *
                           cv::Matx33d(std::cos(b), 0, std::sin(b), 0, 1, 0, -std::sin(b), 0, std::cos(b));
    calibration.translation = {uniform(random, -5, 5), (a > 0 ? -1 : 1) * uniform(random, 160, 220), 0};
    const structured_light::LensTriangulation triangulation(
        calibration,
        {.rows = rows, .columns = columns, .bits = kBits, .row_bits = kBits, .limits = {.max_z_per_line_mm = 8}});
    const RandomPoints points = random_points(random, calibration, triangulation.pixels(), columns);
    const std::vector<std::uint16_t>& codes = points.codes;
    const std::vector<std::uint16_t>& row_codes = points.row_codes;
    const std::vector<double>& truth = points.truth;
    std::vector<float> z(codes.size());
    std::vector<structured_light::PointState> states(codes.size());
    triangulation.depth_of_both(codes.data(), row_codes.data(), z.data(), states.data(), nullptr);
    EXPECT_GT(std::count_if(codes.begin(), codes.end(), [](std::uint16_t code) { return code != 0; }), 0);
    for (std::size_t i = 0; i < codes.size(); ++i) {
      if (codes[i] != 0) {
        ASSERT_EQ(states[i], structured_light::PointState::valid) << "pixel " << i;
        EXPECT_NEAR(static_cast<double>(z[i]), truth[i], 2.5);  // half a row
      }
    }
  }
}

TEST(LensTriangulation, WithoutDistortionIsThePlanes) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(2, 24);
    const int columns = random.between(2, 32);
    const rig::Calibration c = without_distortion(random_calibration(random, columns, rows));
    const int bits = random.between(6, 11);
    const double lines = 1280;
    structured_light::DepthLimits limits{300, 2000, uniform(random, 1, 20)};
    const structured_light::LensTriangulation lens(
        c, {.rows = rows, .columns = columns, .bits = bits, .lines = lines, .limits = limits});
    const cv::Matx34d camera(c.camera.fx, 0, c.camera.cx, 0, 0, c.camera.fy, c.camera.cy, 0, 0, 0, 1, 0);
    cv::Matx<double, 2, 4> projector;
    const double scale = std::ldexp(1.0, bits) / lines;
    for (int k = 0; k < 4; ++k) {
      const auto part = [&](int row) { return k < 3 ? c.rotation(row, k) : c.translation[row]; };
      projector(0, k) = scale * (c.projector.fx * part(0) + (c.projector.cx + 0.5) * part(2));
      projector(1, k) = part(2);
    }
    const structured_light::PlaneTriangulation planes(rows, columns, bits, {camera, projector}, limits, scale);
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
  rig::Calibration c = random_calibration(random, 16, 16);
  c.projector_columns = 1280;
  c.projector_rows = 800;
  const structured_light::LensTriangulation triangulation(
      c, {.rows = 16, .columns = 16, .bits = 11, .row_bits = 11, .limits = {}});
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
    std::vector<structured_light::PointState> states(256);
    triangulation.depth_of_both(codes.data(), row_codes.data(), z.data(), states.data(), nullptr);
    EXPECT_EQ(std::isnan(z[pixel]), states[pixel] != structured_light::PointState::valid);
    return states[pixel];
  };
  EXPECT_EQ(state_of(word(column), word(row)), structured_light::PointState::valid);
  EXPECT_EQ(state_of(word(column), word(row + 20)), structured_light::PointState::off_line);
  EXPECT_EQ(state_of(word(1280), word(row)), structured_light::PointState::no_line);
  EXPECT_EQ(state_of(word(column), word(800)), structured_light::PointState::no_line);
  EXPECT_EQ(state_of(word(column), static_cast<std::uint16_t>(row)), structured_light::PointState::not_measurable);
}

}  // namespace
}  // namespace selfproj::test
