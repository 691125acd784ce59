// Tests self-projected structured light through distorting lenses: reference, patterns, matches and depth, against
// points and pixels written out apart from the host's geometry.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/structured_light/accuracy.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "tests/cli/program.h"
#include "tests/host/light_section/lens_world.h"

namespace selfproj::test {
namespace {

// Rig B with a quarter of its pixels along each side.
rig::Rig coarse_rig() {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows /= 4;
  rig.camera.columns /= 4;
  rig.camera.pixel_pitch_mm *= 4;
  rig.projector.lines /= 4;
  rig.projector.columns /= 4;
  rig.projector.line_pitch_mm *= 4;
  rig.projector.column_pitch_mm *= 4;
  rig.measure.max_z_per_line_mm *= 4;
  return rig;
}

struct Station {
  explicit Station(double k1)
      : ideal(coarse_rig()),
        calibration(distorted_calibration(ideal, {.k1 = k1, .turn = {0, 0, k1 == 0 ? 0.0 : 1.0}})),
        rig(rig::rig_of(calibration, ideal)),
        world(calibration) {}

  // The point of the plane z that a camera pixel sees.
  [[nodiscard]] cv::Vec3d seen(int row, int column, double z) const {
    cv::Vec2d at(0, 0);
    for (int i = 0; i < 30; ++i) {
      const cv::Vec2d here = world.camera({at[0], at[1], z}) - cv::Vec2d(column, row);
      const cv::Vec2d by_x = (world.camera({at[0] + 1e-4, at[1], z}) - cv::Vec2d(column, row) - here) / 1e-4;
      const cv::Vec2d by_y = (world.camera({at[0], at[1] + 1e-4, z}) - cv::Vec2d(column, row) - here) / 1e-4;
      at -= cv::Matx22d(by_x[0], by_y[0], by_x[1], by_y[1]).inv() * here;
      if (std::abs(here[0]) + std::abs(here[1]) < 1e-9) {
        break;
      }
    }
    return {at[0], at[1], z};
  }

  // (column, line) of the projector that lights it, if it is in the image.
  [[nodiscard]] std::optional<cv::Vec2d> light(int row, int column, double z) const {
    const cv::Vec2d lit = world.projector(seen(row, column, z));
    const bool inside =
        lit[0] > 0 && lit[1] > 0 && lit[0] < rig.projector.columns - 1 && lit[1] < rig.projector.lines - 1;
    return inside ? std::optional(lit) : std::nullopt;
  }

  [[nodiscard]] structured_light::SelfReference reference(double z) const {
    structured_light::ProjectorPoints points{images::FloatImage(rig.camera.rows, rig.camera.columns, images::kNoValue),
                                             images::FloatImage(rig.camera.rows, rig.camera.columns, images::kNoValue)};
    for (int r = 0; r < rig.camera.rows; ++r) {
      for (int c = 0; c < rig.camera.columns; ++c) {
        if (const auto lit = light(r, c, z)) {
          points.line.row(r)[c] = static_cast<float>((*lit)[1]);
          points.column.row(r)[c] = static_cast<float>((*lit)[0]);
        }
      }
    }
    structured_light::Stripes stripes;
    return structured_light::make_self_reference(rig, points, stripes);
  }

  rig::Rig ideal;
  rig::Calibration calibration;
  rig::Rig rig;
  LensWorld world;
};

struct Measured {
  double rms = 0;
  int points = 0, far = 0;  // far: errors of more than 30 mm, which are other matches
};

// The depth of a plane at z under the patterns of the reference.
Measured measure(const Station& setup, const structured_light::SelfReference& reference, double z) {
  const rig::Rig& rig = setup.rig;
  const structured_light::MatchTable table(rig, reference, {.e = 4});
  structured_light::SelfScanner scanner(rig, reference, table, rig.measure.code_threshold);
  std::vector<std::uint16_t> codes;
  for (int r = 0; r < rig.camera.rows; ++r) {
    for (int c = 0; c < rig.camera.columns; ++c) {
      const auto lit = setup.light(r, c, z);
      const int cell =
          lit ? reference.cell(static_cast<int>(std::lround((*lit)[1])), static_cast<int>(std::lround((*lit)[0])))
              : structured_light::kNoCell;
      codes.push_back(cell == structured_light::kNoCell
                          ? 0
                          : static_cast<std::uint16_t>(structured_light::code_of_cell(reference.stripes, cell) |
                                                       model::GrayDecoder::kMeasurable));
    }
  }
  scanner.add_codes(codes.data());
  Measured measured;
  double square = 0;
  for (const float depth : scanner.depth().values) {
    if (!std::isnan(depth)) {
      const double off = static_cast<double>(depth) - z;
      measured.far += std::abs(off) > 30 ? 1 : 0;
      square += std::abs(off) > 30 ? 0 : off * off;
      ++measured.points;
    }
  }
  measured.rms = std::sqrt(square / std::max(1, measured.points - measured.far));
  return measured;
}

TEST(LensMatch, PlanesAreAsTrueAsWithoutDistortion) {
  const double heights[] = {0, 40};
  std::vector<Measured> plain;
  for (const double k1 : {0.0, 0.08, -0.08}) {
    const Station setup(k1);
    ASSERT_TRUE(k1 == 0 || !setup.rig.is_pinholes());
    const structured_light::SelfReference reference = setup.reference(setup.rig.plane_z_mm);
    for (std::size_t i = 0; i < std::size(heights); ++i) {
      const Measured measured = measure(setup, reference, setup.rig.plane_z_mm - heights[i]);
      EXPECT_LT(measured.far, measured.points / 50) << k1;
      if (k1 == 0) {
        plain.push_back(measured);
        EXPECT_GT(measured.points, 7000);
        EXPECT_LT(measured.rms, 8);
      } else {
        EXPECT_GT(measured.points, plain[i].points * 8 / 10) << k1;
        EXPECT_LT(measured.rms, 1.2 * plain[i].rms) << k1 << " " << heights[i];
      }
    }
  }
}

// The reference's own depth follows from measured places, and has no rounding.
TEST(LensMatch, DepthOfTheReferenceIsExact) {
  const Station setup(-0.08);
  const structured_light::SelfReference reference = setup.reference(500);
  const structured_light::MatchTable table(setup.rig, reference, {});
  const structured_light::SelfScanner scanner(setup.rig, reference, table, 5);
  int points = 0;
  for (const float depth : scanner.reference_depth().values) {
    if (!std::isnan(depth)) {
      ++points;
      ASSERT_NEAR(depth, 500, 0.005);
    }
  }
  EXPECT_GT(points, 7000);
}

// What the projector lights beyond the camera's view has a place near the image or none, and is read back.
TEST(LensMatch, NothingIsExtrapolatedFar) {
  const ScratchFolder scratch;
  for (const double k1 : {0.08, -0.08, -0.3}) {  // the last one folds over inside the projector's image
    const Station setup(k1);
    const structured_light::SelfReference reference = setup.reference(setup.rig.plane_z_mm);
    std::size_t without = 0;
    for (std::size_t i = 0; i < reference.row.values.size(); ++i) {
      ASSERT_EQ(std::isnan(reference.row.values[i]), std::isnan(reference.column.values[i]));
      ASSERT_FALSE(std::abs(reference.row.values[i]) > 4 * static_cast<float>(setup.rig.camera.rows));
      ASSERT_FALSE(std::abs(reference.column.values[i]) > 4 * static_cast<float>(setup.rig.camera.columns));
      without += std::isnan(reference.row.values[i]) ? 1U : 0U;
    }
    EXPECT_EQ(without > 0, k1 == -0.3) << k1 << ": " << without;
    const std::string name = (scratch / ("reference" + std::to_string(k1))).string();
    files::OutputFolder folder(name);
    structured_light::write_self_reference(setup.rig, reference, folder);
    folder.commit();
    const structured_light::SelfReference read = structured_light::read_self_reference(setup.rig, name);
    EXPECT_EQ(read.seen, reference.seen);
    EXPECT_EQ(read.cell(0, 0), reference.cell(0, 0));
    EXPECT_GT(measure(setup, read, setup.rig.plane_z_mm - 20).points, 5000);
  }
}

// Error and range of a calibrated rig without distortion are those of the closed forms.
TEST(LensMatch, AccuracyIsThatOfTheClosedFormsWithoutDistortion) {
  const rig::Rig rig = rig::load_rig("scanner");
  rig::Rig calibrated = rig::rig_of(rig::calibration_of(rig), rig);
  for (const structured_light::CameraPoint& point :
       {structured_light::CameraPoint{255.5, 255.5, 550}, structured_light::CameraPoint{100, 400, 470}}) {
    const structured_light::ErrorTerms plain = structured_light::error_terms(rig, point, 0.02, 0.005);
    const structured_light::ErrorTerms lens = structured_light::error_terms(calibrated, point, 0.02, 0.005);
    for (const auto& [a, b] : {std::pair{plain.projector, lens.projector}, std::pair{plain.camera, lens.camera}}) {
      EXPECT_NEAR(b.x, a.x, 1e-3);
      EXPECT_NEAR(b.y, a.y, 1e-3);
      EXPECT_NEAR(b.z, a.z, 1e-3);
    }
    const structured_light::DepthRange lines = structured_light::range_of_lines(rig, point, 20, 30);
    const structured_light::DepthRange lens_lines = structured_light::range_of_lines(calibrated, point, 20, 30);
    EXPECT_NEAR(lens_lines.low, lines.low, 1e-3);
    EXPECT_NEAR(lens_lines.high, lines.high, 1e-3);
    const structured_light::DepthRange cells = structured_light::range_of_cells(rig, point, 2, 4, 8);
    const structured_light::DepthRange lens_cells = structured_light::range_of_cells(calibrated, point, 2, 4, 8);
    EXPECT_NEAR(lens_cells.low, cells.low, 1e-3);
    EXPECT_NEAR(lens_cells.high, cells.high, 1e-3);
  }
  calibrated.calibration->camera.k1 = 0.08;
  EXPECT_NE(structured_light::half_pixel_error(calibrated, {50, 50, 550}),
            structured_light::half_pixel_error(rig, {50, 50, 550}));
}

}  // namespace
}  // namespace selfproj::test
