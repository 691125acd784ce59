// Planes are seen through the pinholes of a rig and rounded to codes. Compares the fitted plane with the true one, and
// the residuals with their prediction from rounding.
#include "host/structured_light/plane_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/lens_triangulation.h"
#include "selfproj/structured_light/triangulation.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/host/structured_light/random_rig.h"

namespace selfproj::test {
namespace {

constexpr int kCodeBits = 10;
constexpr double kZ0 = 553;
constexpr double kA = 0.11;
constexpr double kB = -0.07;

// A rig of few pixels, all of whose points count.
rig::Rig small_rig() {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows = 300;
  rig.camera.columns = 260;
  rig.measure.max_z_per_line_mm = 1e3;
  return rig;
}

// The point of the plane z = kZ0 + kA x + kB y on the ray of pixel i; rows run along x.
Point3 on_plane(const rig::Rig& rig, std::size_t i) {
  const auto columns = static_cast<std::size_t>(rig.camera.columns);
  const double scale = rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const std::size_t row = i / columns;
  const std::size_t column = i % columns;
  const double dx = scale * (static_cast<double>(row) - 0.5 * (rig.camera.rows - 1));
  const double dy = scale * (static_cast<double>(column) - 0.5 * (rig.camera.columns - 1));
  const double z = kZ0 / (1 - kA * dx - kB * dy);
  return {dx * z, dy * z, z};
}

std::uint16_t word(double place, int count) {
  EXPECT_TRUE(place > -0.5 && place < count - 0.5) << place;
  return static_cast<std::uint16_t>(std::lround(place)) | kMeasurable;
}

void expect_plane(const structured_light::Triangulation& triangulation, const images::FloatImage& depth) {
  const structured_light::PlaneFit fit = structured_light::fit_plane(triangulation, depth);
  EXPECT_EQ(fit.points, triangulation.pixels());
  // Thousands of errors of about 0.5 mm; the rounding of neighbours is not fully independent.
  EXPECT_NEAR(fit.z0, kZ0, 0.02);
  EXPECT_NEAR(fit.a, kA, 2e-4);
  EXPECT_NEAR(fit.b, kB, 2e-4);
  EXPECT_NEAR(fit.rms, fit.rounding_rms, 0.03 * fit.rounding_rms);
  // An error uniform over a code ends at √3 standard deviations; codes are coarser at one end of the image.
  double coarsest = 0;
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    coarsest = std::max(coarsest, triangulation.rounding_error(i, depth.values[i]));
  }
  EXPECT_LT(fit.greatest, 1.05 * std::sqrt(3.0) * coarsest);
  EXPECT_GT(fit.greatest, 0.8 * std::sqrt(3.0) * coarsest);
}

TEST(PlaneFit, LinesRoundedToCodes) {
  const rig::Rig rig = small_rig();
  const structured_light::PlaneTriangulation triangulation(rig, kCodeBits, {},
                                                           rig::central_lines(rig, 1 << kCodeBits, kCodeBits));
  std::vector<std::uint16_t> codes(triangulation.pixels());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const double first = 0.5 * (rig.projector.lines - (1 << kCodeBits));
    codes[i] = word(projector_lights(rig.projector, on_plane(rig, i)).row - first, 1 << kCodeBits);
  }
  images::FloatImage depth(rig.camera.rows, rig.camera.columns);
  triangulation.depth(codes.data(), depth.values.data());
  expect_plane(triangulation, depth);
}

TEST(PlaneFit, CodesOfBothAxes) {
  const rig::Rig rig = small_rig();
  structured_light::LensSettings settings;
  settings.rows = rig.camera.rows;
  settings.columns = rig.camera.columns;
  settings.bits = kCodeBits;
  settings.row_bits = kCodeBits;
  settings.rows_are_x = true;
  const structured_light::LensTriangulation triangulation(rig::calibration_of(rig), settings);
  std::vector<std::uint16_t> lines(triangulation.pixels());
  std::vector<std::uint16_t> columns(triangulation.pixels());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Pixel lit = projector_lights(rig.projector, on_plane(rig, i));
    lines[i] = word(lit.row, rig.projector.lines);
    columns[i] = word(lit.column, rig.projector.columns);
  }
  images::FloatImage depth(rig.camera.rows, rig.camera.columns);
  triangulation.depth_of_both(lines.data(), columns.data(), depth.values.data(), nullptr, nullptr);
  expect_plane(triangulation, depth);
}

// A board that fills two fifths of the image before a wall that leans otherwise, and points anywhere: the plane is that
// of the board in its region, and that of the wall in the whole image.
TEST(PlaneFit, MostPointsDecide) {
  const rig::Rig rig = small_rig();
  const structured_light::PlaneTriangulation triangulation(rig, kCodeBits);
  images::FloatImage depth(rig.camera.rows, rig.camera.columns);
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    const std::size_t row = i / static_cast<std::size_t>(rig.camera.columns);
    const bool board = row >= 40 && row < 160;
    const double wall = 700 + 40 * static_cast<double>(row) / rig.camera.rows;
    depth.values[i] = static_cast<float>(i % 11 == 0 ? 450 + static_cast<double>(i % 401)
                                         : board     ? on_plane(rig, i).z
                                                     : wall);
  }
  const structured_light::PlaneFit board = structured_light::fit_plane(triangulation, depth, {30, 10, 140, 240});
  EXPECT_NEAR(board.z0, kZ0, 0.05);
  EXPECT_NEAR(board.a, kA, 1e-3);
  EXPECT_NEAR(board.b, kB, 1e-3);
  EXPECT_GT(board.left_out, 2000U);
  EXPECT_EQ(board.points + board.left_out, 140U * 240U);
  const structured_light::PlaneFit all = structured_light::fit_plane(triangulation, depth);
  EXPECT_GT(all.z0, 690);
  EXPECT_LT(all.rms, 1);
  EXPECT_THROW(structured_light::fit_plane(triangulation, depth, {0, 0, rig.camera.rows + 1, 3}),
               std::invalid_argument);
  EXPECT_THROW(structured_light::fit_plane(triangulation, depth, {-1, 0, 3, 3}), std::invalid_argument);
}

TEST(PlaneFit, ExactPointsLeaveNothing) {
  const rig::Rig rig = small_rig();
  const structured_light::PlaneTriangulation triangulation(rig, kCodeBits);
  images::FloatImage depth(rig.camera.rows, rig.camera.columns);
  std::fill(depth.values.begin(), depth.values.end(), std::numeric_limits<float>::quiet_NaN());
  std::size_t points = 0;
  for (std::size_t i = 0; i < depth.values.size(); i += 7, ++points) {
    depth.values[i] = static_cast<float>(on_plane(rig, i).z);
  }
  const structured_light::PlaneFit fit = structured_light::fit_plane(triangulation, depth);
  EXPECT_EQ(fit.points, points);
  EXPECT_NEAR(fit.z0, kZ0, 1e-5);  // 32-bit depths are rounded to 6e-5 mm
  EXPECT_NEAR(fit.a, kA, 1e-7);
  EXPECT_NEAR(fit.b, kB, 1e-7);
  EXPECT_LT(fit.greatest, 1e-4);
}

TEST(PlaneFit, NoPlaneInTooFewPoints) {
  const rig::Rig rig = small_rig();
  const structured_light::PlaneTriangulation triangulation(rig, kCodeBits);
  images::FloatImage depth(rig.camera.rows, rig.camera.columns);
  std::fill(depth.values.begin(), depth.values.end(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(structured_light::fit_plane(triangulation, depth).points, 0U);
  EXPECT_TRUE(std::isnan(structured_light::fit_plane(triangulation, depth).z0));
  for (int r = 0; r < rig.camera.rows; ++r) {
    depth.row(r)[100] = 550;  // at one depth in one column: on a line
  }
  const structured_light::PlaneFit line = structured_light::fit_plane(triangulation, depth);
  EXPECT_EQ(line.points, static_cast<std::size_t>(rig.camera.rows));
  EXPECT_TRUE(std::isnan(line.z0));
  EXPECT_TRUE(std::isnan(line.rms));
  EXPECT_THROW(structured_light::fit_plane(triangulation, images::FloatImage(3, 3)), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
