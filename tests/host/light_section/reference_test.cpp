// Compares references and the pattern of (3.9) with pinholes by vectors.
#include "selfproj/light_section/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host/rig/geometry.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "tests/host/light_section/lens_world.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Geometry, TiltedProjectorAgainstVectors) {
  for (const std::uint64_t seed : seeds(1000)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    rig::RigProjector projector = rig::load_rig("light-section").projector;
    projector.x_mm = uniform(random, 50, 500);
    projector.z_mm = uniform(random, -300, 700);
    projector.tilt_rad = uniform(random, -40, 40) * std::numbers::pi / 180;
    projector.center_xp_mm = uniform(random, -5, 5);
    projector.center_yp_mm = uniform(random, -5, 5);
    const Point3 point{0, uniform(random, -100, 100), uniform(random, 900, 1300)};
    const Pixel pixel = projector_lights(projector, point);
    EXPECT_NEAR(rig::line_on_middle(projector, point.z), pixel.row, 1e-9);
    EXPECT_NEAR(rig::projector_column_on_middle(projector, point.y, point.z), pixel.column, 1e-9);
    const double theta = projector.x_mm / (point.z - projector.z_mm);  // (3.8)
    EXPECT_NEAR(rig::tan_theta(projector, pixel.row), theta, 1e-12);
    EXPECT_NEAR(rig::line_of(projector, theta), pixel.row, 1e-8);
  }
}

TEST(Geometry, CameraAgainstVectors) {
  const rig::RigCamera camera = rig::load_rig("light-section").camera;
  const Point3 point{7, -31, 1100};
  const Pixel pixel = camera_sees(camera, point);
  EXPECT_NEAR(rig::tan_alpha(camera, pixel.row + 1), point.x / point.z, 1e-15);
  EXPECT_NEAR(rig::tan_beta(camera, pixel.column), point.y / point.z, 1e-15);
  EXPECT_NEAR(rig::centroid_of(camera, point.x / point.z), pixel.row + 1, 1e-12);
  EXPECT_NEAR(rig::column_of(camera, point.y / point.z), pixel.column, 1e-12);
  EXPECT_EQ(rig::middle_row(camera), 48.5);  // (3.3)
}

// z of a smooth hill over y, and a curve of its samples.
double hill(double y) { return 1167 - 11.8 * (1 + std::cos(std::numbers::pi * std::clamp(y / 50, -1.0, 1.0))); }

light_section::ReferenceCurve hill_curve() {
  light_section::ReferenceCurve curve;
  for (double y = -70; y <= 70; y += 0.05) {
    curve.y_mm.push_back(y);
    curve.z_mm.push_back(hill(y));
  }
  return curve;
}

TEST(Reference, OfAHill) {
  const rig::Rig rig = rig::load_rig("light-section");
  const light_section::ReferenceProfile reference = light_section::reference_of_curve(rig, hill_curve());
  EXPECT_EQ(reference.valid_columns(), 512);
  for (int i = 0; i < 512; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double y = reference.z_mm[k] * rig::tan_beta(rig.camera, i);
    ASSERT_NEAR(reference.z_mm[k], hill(y), 2e-5) << i;  // the curve's own sagitta: 0.05² / 8 · 0.047
    ASSERT_NEAR(reference.tan_theta[k],
                rig::tan_theta(rig.projector, rig::line_on_middle(rig.projector, reference.z_mm[k])), 1e-12);
    ASSERT_EQ(reference.offset_px[k], 0);
  }
}

// Each point of the pattern lights the point (0, y, z) of the hill.
TEST(Reference, PatternLightsTheHillAtTheMiddleRow) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::vector<double> lines = light_section::pattern_of_curve(rig, hill_curve());
  ASSERT_EQ(lines.size(), 512U);
  int lit = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (std::isnan(lines[i])) {
      continue;
    }
    ++lit;
    const double z = rig.projector.x_mm / rig::tan_theta(rig.projector, lines[i]) + rig.projector.z_mm;
    // The y at which the projector's column meets the surface.
    double low = -70;
    double high = 70;
    for (int step = 0; step < 60; ++step) {
      const double y = 0.5 * (low + high);
      (projector_lights(rig.projector, {0, y, z}).column < static_cast<double>(i) ? low : high) = y;
    }
    ASSERT_NEAR(z, hill(low), 3e-5) << i;
  }
  EXPECT_EQ(lit, 512);
}

TEST(Reference, CurveOfAReferenceIsTheReferenceAgain) {
  const rig::Rig rig = rig::load_rig("light-section");
  const light_section::ReferenceProfile reference = light_section::reference_of_curve(rig, hill_curve());
  const light_section::ReferenceProfile again =
      light_section::reference_of_curve(rig, light_section::curve_of_reference(rig, reference));
  EXPECT_EQ(again.valid_columns(), 512);
  for (std::size_t i = 0; i < again.valid.size(); ++i) {
    ASSERT_NEAR(again.z_mm[i], reference.z_mm[i], 1e-6);
  }
}

// A block of 30 mm between y = -20 and 20, and a gap in the plane beside it.
TEST(Reference, StepsShadowsAndGapsAreDark) {
  const rig::Rig rig = rig::load_rig("light-section");
  light_section::ReferenceCurve curve{{-70, -20, -20, 20, 20, 30, 32, 70},
                                      {1167, 1167, 1137, 1137, 1167, 1167, 1167, 1167}};
  curve.z_mm[5] = kNan;  // nothing between 20 and 32
  const light_section::ReferenceProfile reference = light_section::reference_of_curve(rig, curve);
  const double block = 20 / 1137.0;                                // tan β where the block ends
  const double shadow = 20 * (1167. - 579) / (1137 - 579) / 1167;  // and where the projector's shadow does
  for (int i = 0; i < 512; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double beta = rig::tan_beta(rig.camera, i);
    if (std::abs(beta) < block) {
      ASSERT_NEAR(reference.z_mm[k], 1137, 1e-9) << i;
    } else if (beta < -shadow || beta > 32 / 1167.) {
      ASSERT_NEAR(reference.z_mm[k], 1167, 1e-9) << i;
    } else {
      ASSERT_EQ(reference.valid[k], 0) << i;
      ASSERT_TRUE(std::isnan(reference.z_mm[k]));
    }
  }
  // The pattern has two levels and nothing between them.
  const double low = rig::line_on_middle(rig.projector, 1167);
  const double high = rig::line_on_middle(rig.projector, 1137);
  int dark = 0;
  int on_block = 0;
  for (const double line : light_section::pattern_of_curve(rig, curve)) {
    if (std::isnan(line)) {
      ++dark;
      continue;
    }
    ASSERT_TRUE(std::abs(line - low) < 1e-6 || std::abs(line - high) < 1e-6) << line;
    on_block += std::abs(line - high) < 1e-6 ? 1 : 0;
  }
  EXPECT_GT(dark, 40);  // 12 mm of gap and 1 mm of shadow on the other side are 55 columns of 0.236 mm
  EXPECT_LT(dark, 70);
  EXPECT_NEAR(on_block, 40 / 0.226, 3);
}

// Columns beside walls of a self-projected pattern see light of both sides. A straight line has no walls.
TEST(Reference, WithoutWallsLeavesOutWhereTheLightJumps) {
  const rig::Rig pinholes = rig::load_rig("light-section");
  const rig::Rig lens = rig::rig_of(
      distorted_calibration(pinholes, {.k1 = 0.05, .k2 = 0, .p1 = 0, .p2 = 0, .turn = {0, 0, 0}, .move = {3, -3, 3}}),
      pinholes);
  for (const rig::Rig& rig : {pinholes, lens}) {
    const double plane = rig.plane_z_mm;
    const light_section::ReferenceProfile reference =
        light_section::reference_of_curve(rig, {{-500, 0, 0, 500}, {plane, plane, plane - 9, plane - 9}});
    const light_section::ReferenceProfile without = light_section::without_walls(rig, reference);
    int left = 0;  // the last column that sees the plane
    int right = reference.columns();
    for (int c = 0; c < reference.columns(); ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (reference.valid[i] != 0) {
        (reference.z_mm[i] > plane - 1 ? left : right) = reference.z_mm[i] > plane - 1 ? c : std::min(right, c);
      }
    }
    EXPECT_GT(left, 100);
    EXPECT_LE(right - left, 8);
    for (int c = 0; c < reference.columns(); ++c) {
      const auto i = static_cast<std::size_t>(c);
      EXPECT_EQ(without.valid[i] != 0, reference.valid[i] != 0 && (c < left - 3 || c > right + 3)) << c;
    }
  }
  const std::vector<double> middle(static_cast<std::size_t>(pinholes.camera.columns), rig::middle_row(pinholes.camera));
  light_section::ReferenceProfile straight =
      light_section::reference_of_straight_line(pinholes, 0.5 * pinholes.projector.lines, middle);
  straight.valid[200] = 0;
  EXPECT_EQ(light_section::without_walls(pinholes, straight).valid, straight.valid);
}

TEST(Reference, OutsideTheProjectorsImageIsInvalid) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.projector.columns = 256;  // of half the width
  const std::vector<double> flat(512, 0);
  const light_section::ReferenceProfile reference =
      light_section::reference_of_curve(rig, light_section::curve_of_heights(rig, flat));
  for (int i = 0; i < 512; ++i) {
    const Pixel pixel = projector_lights(rig.projector, {0, 1167 * rig::tan_beta(rig.camera, i), 1167});
    ASSERT_EQ(reference.valid[static_cast<std::size_t>(i)] != 0, pixel.column >= -0.5 && pixel.column <= 255.5) << i;
  }
  rig = rig::load_rig("light-section");
  rig.plane_z_mm = 2000;  // its line is beyond the last one
  EXPECT_EQ(light_section::reference_of_curve(rig, light_section::curve_of_heights(rig, flat)).valid_columns(), 0);
  for (const double line : light_section::pattern_of_curve(rig, light_section::curve_of_heights(rig, flat))) {
    ASSERT_TRUE(std::isnan(line));
  }
}

TEST(Reference, ResidualMovesTheLightPlaneAndNotTheReference) {
  const rig::Rig rig = rig::load_rig("light-section");
  const light_section::ReferenceProfile reference = light_section::reference_of_curve(rig, hill_curve());
  std::vector<double> centroid(512, 48.5 + 0.25);
  centroid[7] = kNan;
  const light_section::ReferenceProfile corrected = light_section::without_residual(rig, reference, centroid);
  EXPECT_EQ(corrected.valid[7], 0);
  EXPECT_EQ(corrected.valid_columns(), 511);
  EXPECT_EQ(corrected.z_mm[8], reference.z_mm[8]);
  EXPECT_DOUBLE_EQ(corrected.offset_px[8], 0.25);
  // The plane through the projector and what was seen.
  const double x = 0.25 * 0.01 / 50 * reference.z_mm[8];
  EXPECT_NEAR(corrected.tan_theta[8], (352 - x) / (reference.z_mm[8] - 579), 1e-15);
}

// Rows of frames count from where the frame begins, those of the reference from the sensor's first row.
TEST(Reference, FramesCountWhatItsImagesCounted) {
  using light_section::Selection;
  const auto unlike = [](const Selection& reference, const Selection& frames, int offset, int rows) {
    return light_section::unlike_reference(reference, frames, offset, rows);
  };
  const Selection all{.select = model::Select::all, .gap = 0, .window = {}};
  const auto rows = [](int first, int last) {
    return Selection{.select = model::Select::all, .gap = 0, .window = {first, last}};
  };
  EXPECT_EQ(light_section::unlike_reference({}, rows(3, 5), 7, 20), "");
  // The whole sensor of 96 rows, and the rows 39 to 58 of it
  for (const auto& [offset, height] : {std::pair{0, 96}, {38, 20}}) {
    SCOPED_TRACE(offset);
    EXPECT_EQ(unlike(all, all, offset, height), "");
    EXPECT_EQ(unlike(rows(41, 50), rows(41 - offset, 50 - offset), offset, height), "");
    EXPECT_NE(unlike(rows(41, 50), rows(40 - offset, 50 - offset), offset, height), "");
    EXPECT_NE(unlike(rows(41, 50), rows(41 - offset, 51 - offset), offset, height), "");
    EXPECT_NE(unlike(rows(41, 50), all, offset, height), "");
    EXPECT_NE(unlike(all, rows(41 - offset, 50 - offset), offset, height), "");
    // Rows that the frame has not do not count, and a window may end behind it.
    EXPECT_EQ(unlike(all, rows(1, height), offset, height), "");
    EXPECT_EQ(unlike(all, rows(1, height + 9), offset, height), "");
    EXPECT_EQ(unlike(rows(offset + 1, 96), all, offset, height), "");
    EXPECT_EQ(unlike(rows(41, 0), rows(41 - offset, 0), offset, height), "");
    EXPECT_EQ(unlike(rows(41, 0), rows(41 - offset, height), offset, height), "");
    EXPECT_NE(unlike(rows(41, 0), rows(42 - offset, 0), offset, height), "");
  }
  const Selection strongest{.select = model::Select::strongest, .gap = 1, .window = {}};
  EXPECT_NE(unlike(strongest, all, 0, 96), "");
  EXPECT_EQ(
      unlike(rows(41, 50), strongest, 38, 20),
      "of its columns counted the strongest run, gap 1, rows 39..58; in the images of the reference it was all lit "
      "pixels, rows 41..50");
}

TEST(Reference, StraightLine) {
  const rig::Rig rig = rig::load_rig("light-section");
  const double line = rig::line_on_middle(rig.projector, 1167);
  const light_section::ReferenceProfile reference =
      light_section::reference_of_straight_line(rig, line, std::vector<double>(512, 48.5));
  for (const double z : reference.z_mm) {
    ASSERT_NEAR(z, 1167, 1e-9);
  }
  EXPECT_THROW(light_section::reference_of_straight_line(rig, line, std::vector<double>(511, 48.5)),
               std::invalid_argument);
  EXPECT_THROW(light_section::curve_of_heights(rig, std::vector<double>(513)), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
