// Compares errors and ranges with differences of the geometry itself, and with the figures of the thesis.

#include "host/structured_light/accuracy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "selfproj/rig/rig.h"
#include "tests/host/light_section/seen_surface.h"
#include "tests/host/structured_light/pinhole.h"

namespace selfproj::test {
namespace {

constexpr double kMiddle = 255.5;

// The line that lights a point of a pixel's ray, by pinholes.
double line_at(const rig::Rig& rig, double row, double column, double z) {
  return projector_lights(rig.projector, test::on_ray(rig.camera, row, column, z)).row;
}

// z at which the pixel sees the line, by halving.
double z_at(const rig::Rig& rig, double row, double column, double line) {
  double low = 350;
  double high = 900;
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    (line_at(rig, row, column, middle) > line ? low : high) = middle;
  }
  return low;
}

TEST(Accuracy, TermsAreTheDerivativesOfTheGeometry) {
  const rig::Rig rig = rig::load_rig("scanner");
  constexpr double kStep = 1e-4;
  for (const double row : {100.0, kMiddle, 330.0}) {
    for (const double column : {60.0, kMiddle, 400.0}) {
      for (const double z : {440.0, 525.0, 550.0}) {
        const double line = line_at(rig, row, column, z);
        const structured_light::ErrorTerms terms = structured_light::error_terms(
            rig, {row, column, z}, kStep * rig.projector.line_pitch_mm, kStep * rig.camera.pixel_pitch_mm);
        const auto difference = [&](double rows, double lines) {
          const auto at = [&](double sign) {
            const double r = row + sign * rows;
            return test::on_ray(rig.camera, r, column, z_at(rig, r, column, line + sign * lines));
          };
          const Point3 b = at(0.5);
          const Point3 a = at(-0.5);
          return Point3{b.x - a.x, b.y - a.y, b.z - a.z};
        };
        const Point3 projector = difference(0, kStep);
        const Point3 camera = difference(kStep, 0);
        const double bound = 1e-6;
        EXPECT_NEAR(terms.projector.x, projector.x, bound);
        EXPECT_NEAR(terms.projector.y, projector.y, bound);
        EXPECT_NEAR(terms.projector.z, projector.z, bound);
        EXPECT_NEAR(terms.camera.x, camera.x, bound);
        EXPECT_NEAR(terms.camera.y, camera.y, bound);
        EXPECT_NEAR(terms.camera.z, camera.z, bound);
      }
    }
  }
}

// B5: half a pixel of each, at the centre.
TEST(Accuracy, DerivedFiguresOfTheThesis) {
  const rig::Rig rig = rig::load_rig("scanner");
  EXPECT_NEAR(structured_light::half_pixel_error(rig, {kMiddle, kMiddle, 550}), 1.79, 0.005);
  EXPECT_NEAR(structured_light::half_pixel_error(rig, {kMiddle, kMiddle, 525}), 1.50, 0.005);
  EXPECT_NEAR(structured_light::half_pixel_error(rig, {kMiddle, kMiddle, 441}), 0.72, 0.005);
  const structured_light::DepthRange published =
      structured_light::range_of_lines(rig, {kMiddle, kMiddle, 550}, 0, 48);  // B6
  EXPECT_NEAR(published.low, 496.7, 0.05);
  EXPECT_NEAR(published.high, 550, 1e-9);
  EXPECT_NEAR(structured_light::range_of_lines(rig, {kMiddle, kMiddle, 550}, 0, 96).low, 461.3, 0.05);
}

TEST(Accuracy, ApproximationIsTheLimitOfSmallAngles) {
  const rig::Rig rig = rig::load_rig("scanner");
  // The light leaves along the projector's axis: θ = θ0, α = 0.
  const double z = rig.projector.z_mm + rig.projector.x_mm / std::tan(rig.projector.tilt_rad);
  const structured_light::ErrorTerms exact = structured_light::error_terms(rig, {kMiddle, kMiddle, z}, 0.01, 0.01);
  const structured_light::ErrorTerms approximate = structured_light::approximate_error(rig, 0.01, 0.01);
  EXPECT_NEAR(std::abs(exact.projector.z), approximate.projector.z, 1e-9);
  EXPECT_NEAR(exact.camera.z, approximate.camera.z, 1e-9);
}

// The window in cells on a plane: the light at its ends falls on the rows that bound the cells.
TEST(Accuracy, RangeOfCellsEndsAtTheirEdges) {
  const rig::Rig rig = rig::load_rig("scanner");
  for (const double z : {550.0, 525.0, 441.0}) {
    for (const int e : {0, 8, 15}) {
      for (const double row : {200.0, 256.0, 301.0}) {
        const structured_light::DepthRange range = structured_light::range_of_cells(rig, {row, kMiddle, z}, 2, 4, e);
        // The row in which the camera would see the light on the plane.
        const auto row_on_plane = [&](double seen_z) {
          const double line = line_at(rig, row, kMiddle, seen_z);
          double low = -400;
          double high = 460;
          for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (low + high);
            (line_at(rig, middle, kMiddle, z) > line ? low : high) = middle;
          }
          return low;
        };
        const double first = kMiddle + 2 * std::floor((row - kMiddle) / 2);  // of the pixel's own cell
        EXPECT_NEAR(row_on_plane(range.low), first - 2 * (15 - e), 1e-3);
        EXPECT_NEAR(row_on_plane(range.high), first + 2 * (e + 1), 1e-3);
        EXPECT_LE(range.low, z);
        EXPECT_GE(range.high, z);
      }
    }
  }
}

}  // namespace
}  // namespace selfproj::test
