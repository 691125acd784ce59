// Tests lenses, rigs made from calibrations and the other way round.
#include "selfproj/rig/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/core/matx.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/lens_triangulation.h"
#include "selfproj/structured_light/triangulation.h"
#include "tests/host/rig/random_lens.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/support/error_of.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(Lens, PixelAndRayAreEachOthersReverse) {
  for (const std::uint64_t seed : seeds(300)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const rig::Lens lens = random_lens(random, 1500, 1280, 800);
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
  const rig::Lens lens{1000, 1000, 500, 500, {-0.5, 0, 0, 0, 0, 0, 0, 0}};  // r (1 - r²/2) is 0.544 at most
  EXPECT_TRUE(lens.ray({1000, 500}).has_value());
  EXPECT_FALSE(lens.ray({1100, 500}).has_value());
}

// Rigs of both directions of counting.
std::vector<rig::Rig> rigs() {
  std::vector<rig::Rig> result;
  for (const std::string name : {"light-section", "scanner"}) {
    rig::Rig rig = rig::load_rig(name);
    rig.projector.center_yp_mm = 0.7;
    for (const int signs : {0, 1, 2, 3}) {
      result.push_back(rig);
      result.back().projector.line_pitch_mm *= (signs & 1) != 0 ? -1 : 1;
      result.back().projector.column_pitch_mm *= (signs & 2) != 0 ? -1 : 1;
    }
  }
  return result;
}

TEST(RigCalibration, MapsPointsAsTheRig) {
  for (const rig::Rig& rig : rigs()) {
    const rig::Calibration c = rig::calibration_of(rig);
    EXPECT_NEAR(cv::determinant(c.rotation), 1, 1e-12);
    for (const Point3 p : {Point3{5, -20, 500}, {-8, 31, 620}, {0, 0, 900}}) {
      const Pixel camera = camera_sees(rig.camera, p);
      const Pixel projector = projector_lights(rig.projector, p);
      const cv::Vec3d at(p.y, p.x, p.z);  // x along columns
      const cv::Vec2d seen = c.camera.pixel({at[0] / at[2], at[1] / at[2]});
      EXPECT_NEAR(seen[0], camera.column, 1e-9);
      EXPECT_NEAR(seen[1], camera.row, 1e-9);
      const cv::Vec3d there = c.rotation * at + c.translation;
      const cv::Vec2d lit = c.projector.pixel({there[0] / there[2], there[1] / there[2]});
      EXPECT_NEAR(lit[0], projector.column, 1e-8);
      EXPECT_NEAR(lit[1], projector.row, 1e-8);
      // The matrices of (4.7).
      for (const rig::CodedAxis axis : {rig::CodedAxis::columns, rig::CodedAxis::rows}) {
        const rig::DepthMatrices m = rig::depth_matrices(c, axis);
        const cv::Vec4d world(at[0], at[1], at[2], 1);
        const cv::Vec3d image = m.camera * world;
        EXPECT_NEAR(image[0] / image[2], camera.column, 1e-9);
        EXPECT_NEAR(image[1] / image[2], camera.row, 1e-9);
        const cv::Vec2d code = m.projector * world;
        EXPECT_NEAR(code[0] / code[1], (axis == rig::CodedAxis::rows ? projector.row : projector.column) + 0.5, 1e-8);
      }
    }
  }
}

// The rig is recovered for every way of counting lines and columns.
TEST(RigCalibration, NearestRigOfARigIsItself) {
  for (const rig::Rig& rig : rigs()) {
    rig::Calibration c = rig::calibration_of(rig);
    if (c.projector.fx < 0) {  // a projector that hangs upside down
      c.projector.fx *= -1;
      c.projector.fy *= -1;
      const cv::Matx33d half(-1, 0, 0, 0, -1, 0, 0, 0, 1);
      c.rotation = half * c.rotation;
      c.translation = half * c.translation;
    }
    rig::Rig like = rig;
    like.projector.tilt_rad = 0;
    like.projector.x_mm = 1;
    like.camera.focal_length_mm = 1;
    const rig::Rig again = rig::rig_of(c, like);
    EXPECT_NEAR(again.projector.x_mm, rig.projector.x_mm, 1e-9);
    EXPECT_NEAR(again.projector.z_mm, rig.projector.z_mm, 1e-9);
    EXPECT_NEAR(again.projector.tilt_rad, rig.projector.tilt_rad, 1e-12);
    EXPECT_NEAR(again.projector.line_pitch_mm, rig.projector.line_pitch_mm, 1e-12);
    EXPECT_NEAR(again.projector.column_pitch_mm, rig.projector.column_pitch_mm, 1e-12);
    EXPECT_NEAR(again.projector.center_xp_mm, rig.projector.center_xp_mm, 1e-9);
    EXPECT_NEAR(again.projector.center_yp_mm, rig.projector.center_yp_mm, 1e-9);
    EXPECT_NEAR(again.camera.focal_length_mm, rig.camera.focal_length_mm, 1e-9);
    EXPECT_LT(rig::pinhole_error(again, rig.plane_z_mm), 1e-6);
    // Through YAML, with its full model.
    const rig::Rig read = rig::parse_rig(rig::to_yaml(again), "rig.yaml");
    ASSERT_TRUE(read.calibration.has_value());
    EXPECT_EQ(rig::to_yaml(read), rig::to_yaml(again));
    const rig::Calibration full = rig::calibration_of(read);
    EXPECT_LT(cv::norm(full.rotation - c.rotation), 1e-12);
    EXPECT_LT(cv::norm(full.translation - c.translation), 1e-9);
    EXPECT_EQ(full.projector.fy, c.projector.fy);
  }
}

TEST(RigCalibration, WhatARigCannotBe) {
  const rig::Rig rig = rig::load_rig("scanner");
  rig::Calibration c = rig::calibration_of(rig);
  c.translation = c.rotation * cv::Vec3d(-200, -50, 0);  // beside the columns
  EXPECT_THROW(rig::rig_of(c, rig), std::invalid_argument);
  c = rig::calibration_of(rig);
  c.camera_rows = 0;
  EXPECT_THROW(rig::rig_of(c, rig), std::invalid_argument);
  // Departures from the pinholes are reported.
  c = rig::calibration_of(rig);
  c.camera.cy += 3;
  EXPECT_GT(rig::pinhole_error(rig::rig_of(c, rig), 550), 1);
}

TEST(RigCalibration, FullModelGivesTheRigsDepth) {
  for (const double sign : {1.0, -1.0}) {
    rig::Rig rig = rig::load_rig("scanner");
    rig.camera.rows = 40;
    rig.camera.columns = 24;
    rig.camera.pixel_pitch_mm = 0.11;
    rig.projector.line_pitch_mm *= sign;
    constexpr int kBits = 8;
    const structured_light::PlaneTriangulation pinholes(rig, kBits);
    structured_light::LensSettings settings;
    settings.rows = rig.camera.rows;
    settings.columns = rig.camera.columns;
    settings.bits = kBits;
    settings.lines = rig.projector.lines;
    settings.limits.max_z_per_line_mm = rig.measure.max_z_per_line_mm;
    settings.rows_are_x = true;
    const structured_light::LensTriangulation full(rig::calibration_of(rig), settings);
    std::vector<std::uint16_t> codes(pinholes.pixels());
    std::vector<float> a(codes.size());
    std::vector<float> b(codes.size());
    int seen = 0;
    int differing = 0;
    for (int code = 0; code < 1 << kBits; code += 5) {
      std::fill(codes.begin(), codes.end(), static_cast<std::uint16_t>(0x8000 | code));
      pinholes.depth(codes.data(), a.data());
      full.depth(codes.data(), b.data());
      for (std::size_t i = 0; i < a.size(); ++i) {
        differing += std::isnan(a[i]) != std::isnan(b[i]) ? 1 : 0;  // on a limit
        if (!std::isnan(a[i]) && !std::isnan(b[i])) {
          ++seen;
          ASSERT_NEAR(static_cast<double>(a[i]), static_cast<double>(b[i]), 5e-3);
          const structured_light::Point3f p = pinholes.point(i, a[i]);
          const structured_light::Point3f q = full.point(i, b[i]);
          ASSERT_NEAR(static_cast<double>(p.x), static_cast<double>(q.x), 5e-3);
          ASSERT_NEAR(static_cast<double>(p.y), static_cast<double>(q.y), 5e-3);
        }
      }
    }
    EXPECT_GT(seen, 10000);
    EXPECT_LT(differing, seen / 100);
  }
}

TEST(RigCalibration, SectionsAreAllThereOrNone) {
  const rig::Rig rig = rig::load_rig("scanner");
  const std::string yaml = rig::to_yaml(rig::rig_of(rig::calibration_of(rig), rig));
  const auto error_of = [](const std::string& text) {
    return test::error_of([&] { rig::parse_rig(text, "rig.yaml"); });
  };
  EXPECT_EQ(error_of(yaml), "none");
  EXPECT_EQ(error_of(yaml.substr(0, yaml.find("projector_pose"))), "rig.yaml: projector_pose is missing");
  std::string zero = yaml;
  const std::size_t at = zero.find("fy_px: -");
  ASSERT_NE(at, std::string::npos);
  zero.replace(at, zero.find('\n', at) - at, "fy_px: 0");
  EXPECT_NE(error_of(zero).find("projector_lens.fy_px is 0"), std::string::npos) << error_of(zero);
  std::string unit = yaml;
  unit.replace(unit.find("rotation_x_deg"), 14, "rotation_x_rad");
  EXPECT_NE(error_of(unit).find("projector_pose.rotation_x_rad: unknown key; the key is rotation_x_deg"),
            std::string::npos)
      << error_of(unit);
}

}  // namespace
}  // namespace selfproj::test
