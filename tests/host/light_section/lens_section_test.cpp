// Tests references, patterns and profiles of rigs with lenses, a laser's plane, and any pose, against points and pixels
// written out apart from the host's geometry.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/light_section/pattern.h"
#include "host/light_section/scan.h"
#include "host/rig/geometry.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "tests/host/light_section/lens_world.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

constexpr std::uint32_t kLight = 1U << 20U;  // M0: the centroid is exact to 1e-6 rows
constexpr int kEvery = 16;                   // columns between those that are looked at

const Distortion kDistortions[] = {
    {.k1 = 0.08, .k2 = 0.01, .p1 = 0.001, .p2 = -0.001, .turn = {0.5, -0.5, 0.5}, .move = {5, -5, 5}},
    {.k1 = -0.08, .k2 = -0.02, .p1 = -0.001, .p2 = 0.002, .turn = {-0.5, 0.5, -2}, .move = {-5, 5, 5}}};

std::vector<double> level(const rig::Rig& rig, double height) {
  return std::vector<double>(static_cast<std::size_t>(rig.camera.columns), height);
}

// The moments of thin lines of 5 rows with these centroids (from 1; NaN: none).
model::Moments moments_of(const std::vector<double>& centroids) {
  model::Moments moments;
  moments.resize(static_cast<int>(centroids.size()));
  for (std::size_t i = 0; i < centroids.size(); ++i) {
    const bool lit = !std::isnan(centroids[i]);
    moments.m0[i] = lit ? kLight : 0;
    moments.m1[i] = lit ? static_cast<std::uint32_t>(std::lround(centroids[i] * kLight)) : 0;
    moments.n[i] = lit ? 5 : 0;
  }
  return moments;
}

// The points that each kEvery-th column sees, in the rig's axes (x along rows), and the profile of their rows.
struct Seen {
  std::vector<cv::Vec3d> points;
  light_section::Profile profile;
};

Seen measure(const rig::Rig& rig, const light_section::ReferenceProfile& reference, const LensWorld& world,
             const std::function<double(double, double)>& surface, const std::function<double(double)>& line) {
  Seen seen;
  std::vector<double> centroids = level(rig, rig::kUnknown);
  seen.points.resize(centroids.size());
  for (std::size_t i = 0; i < centroids.size(); i += kEvery) {
    if (reference.valid[i] == 0) {
      continue;
    }
    const cv::Vec3d at = world.lit_point(static_cast<double>(i), surface, line);
    centroids[i] = world.camera(at)[1] + 1;
    seen.points[i] = {at[1], at[0], at[2]};
  }
  const model::Moments moments = moments_of(centroids);
  model::Moments copy = moments;
  seen.profile.resize(rig.camera.columns);
  light_section::DifferentialProfiler(rig, reference).profile(copy.view(), seen.profile.view());
  return seen;
}

TEST(LensSection, ProfilesOfAPlaneAreTrueThroughBothLenses) {
  const rig::Rig ideal = rig::load_rig("light-section");
  for (const Distortion& distortion : kDistortions) {
    const rig::Calibration calibration = distorted_calibration(ideal, distortion);
    const rig::Rig rig = rig::rig_of(calibration, ideal);
    const LensWorld world(calibration);
    const light_section::ReferenceCurve curve = light_section::curve_of_heights(rig, level(rig, 0));
    const light_section::ReferenceProfile reference = light_section::reference_of_curve(rig, curve);
    ASSERT_GT(reference.valid_columns(), rig.camera.columns * 8 / 10);  // the projector is turned away from a few
    const auto line = between(light_section::pattern_of_curve(rig, curve));
    const light_section::DifferentialProfiler profiler(rig, reference);
    ASSERT_NE(profiler.curves(), nullptr);
    EXPECT_LE(profiler.curves()->fit_error_mm(), 0.001);
    int points = 0;
    std::vector<cv::Vec3d> of_reference;
    for (const double height : {0.0, 12.0, -8.0}) {
      const double z = rig.plane_z_mm - height;
      const Seen seen = measure(
          rig, reference, world, [&](double, double) { return z; }, line);
      of_reference = height == 0 ? seen.points : of_reference;
      for (std::size_t i = 0; i < seen.points.size(); i += kEvery) {
        if (std::isnan(seen.points[i][0]) || reference.valid[i] == 0) {  // beside the pattern
          continue;
        }
        ++points;
        ASSERT_EQ(seen.profile.validity[i], 0) << i;
        ASSERT_NEAR(seen.profile.z[i], z, 0.002) << i;
        ASSERT_NEAR(seen.profile.x[i], seen.points[i][0], 0.002) << i;
        ASSERT_NEAR(seen.profile.y[i], seen.points[i][1], 0.002) << i;
        ASSERT_NEAR(seen.profile.dz[i], -height, 0.002) << i;
        if (!std::isnan(of_reference[i][0])) {
          ASSERT_NEAR(seen.profile.dx[i], seen.points[i][0] - of_reference[i][0], 0.002) << i;
          ASSERT_NEAR(seen.profile.dy[i], seen.points[i][1] - of_reference[i][1], 0.002) << i;
        }
      }
      if (height == 0) {  // self-projection: the line is on the middle row
        for (std::size_t i = 0; i < seen.points.size(); i += kEvery) {
          if (!std::isnan(seen.profile.centroid[i])) {
            ASSERT_NEAR(seen.profile.centroid[i], rig::middle_row(rig.camera), 0.002) << i;
          }
        }
      }
    }
    EXPECT_GT(points, 3 * rig.camera.columns / kEvery * 3 / 4);
  }
}

// A slanted part on a slanted reference: here the light varies along y, and a column off the reference sees light that
// was drawn for its neighbours.
TEST(LensSection, SlantedPartsAreTrue) {
  const rig::Rig ideal = rig::load_rig("light-section");
  const rig::Calibration calibration = distorted_calibration(ideal, kDistortions[0]);
  const rig::Rig rig = rig::rig_of(calibration, ideal);
  const LensWorld world(calibration);
  const auto height = [](double y) { return 10 + 0.3 * y; };
  const light_section::ReferenceCurve curve{{-100, 100}, {rig.plane_z_mm - height(-100), rig.plane_z_mm - height(100)}};
  const light_section::ReferenceProfile reference = light_section::reference_of_curve(rig, curve);
  const auto line = between(light_section::pattern_of_curve(rig, curve));
  const auto part = [&](double y, double /*x*/) { return rig.plane_z_mm - height(y) - 1.5; };
  const Seen seen = measure(rig, reference, world, part, line);
  const Seen without = measure(
      rig, reference, world, [&](double y, double /*x*/) { return rig.plane_z_mm - height(y); }, line);
  for (std::size_t i = 0; i < seen.points.size(); i += kEvery) {
    if (reference.valid[i] == 0) {
      continue;
    }
    ASSERT_EQ(seen.profile.validity[i], 0) << i;
    ASSERT_NEAR(seen.profile.z[i], seen.points[i][2], 0.002) << i;
    ASSERT_NEAR(seen.profile.y[i], seen.points[i][1], 0.002) << i;
    const cv::Vec3d difference = seen.points[i] - without.points[i];
    ASSERT_NEAR(seen.profile.dx[i], difference[0], 0.002) << i;
    ASSERT_NEAR(seen.profile.dy[i], difference[1], 0.002) << i;
    ASSERT_NEAR(seen.profile.dz[i], difference[2], 0.002) << i;
  }
}

TEST(LensSection, LasersPlaneOfAnyOrientationIsFollowed) {
  const rig::Rig ideal = rig::load_rig("light-section");
  rig::Calibration calibration = distorted_calibration(ideal, kDistortions[1]);
  rig::Rig rig = rig::rig_of(calibration, ideal);
  const cv::Vec3d normal = cv::normalize(cv::Vec3d(0.05, 0.85, 0.5));  // in the calibration's axes
  const double distance = normal.dot({0, 0, rig.plane_z_mm});
  rig.light_plane = rig::RigLightPlane{{normal[0], normal[1], normal[2]}, distance};
  rig = rig::parse_rig(rig::to_yaml(rig), "rig.yaml");
  const LensWorld world(calibration);
  const light_section::ReferenceProfile reference =
      light_section::reference_of_curve(rig, light_section::curve_of_heights(rig, level(rig, 0)));
  ASSERT_GT(reference.valid_columns(), rig.camera.columns * 9 / 10);
  const light_section::DifferentialProfiler profiler(rig, reference);
  int points = 0;
  std::vector<cv::Vec3d> of_reference(static_cast<std::size_t>(rig.camera.columns));
  for (const double height : {0.0, 4.0}) {
    for (int c = 0; c < rig.camera.columns; c += kEvery) {
      // The point of the light plane at this height that the column sees.
      const double z = rig.plane_z_mm - height;
      double x = 0;
      const auto at = [&](double along) {
        return cv::Vec3d(along, (distance - normal[0] * along - normal[2] * z) / normal[1], z);
      };
      for (int step = 0; step < 30; ++step) {
        const double slope = (world.camera(at(x + 1e-4))[0] - world.camera(at(x))[0]) / 1e-4;
        x -= (world.camera(at(x))[0] - c) / slope;
      }
      std::vector<double> centroids = level(rig, rig::kUnknown);
      centroids[static_cast<std::size_t>(c)] = world.camera(at(x))[1] + 1;
      model::Moments moments = moments_of(centroids);
      light_section::Profile profile;
      profile.resize(rig.camera.columns);
      profiler.profile(moments.view(), profile.view());
      const auto i = static_cast<std::size_t>(c);
      of_reference[i] = height == 0 ? at(x) : of_reference[i];
      if (centroids[i] > 4 && centroids[i] < rig.camera.rows - 3 && reference.valid[i] != 0) {
        ASSERT_EQ(profile.validity[i], 0) << c;
        ASSERT_NEAR(profile.z[i], z, 0.002) << c;
        ASSERT_NEAR(profile.dz[i], -height, 0.002) << c;
        ASSERT_NEAR(profile.x[i], at(x)[1], 0.002) << c;
        ASSERT_NEAR(profile.y[i], at(x)[0], 0.002) << c;
        ASSERT_NEAR(profile.dx[i], at(x)[1] - of_reference[i][1], 0.002) << c;
        ASSERT_NEAR(profile.dy[i], at(x)[0] - of_reference[i][0], 0.002) << c;
        ++points;
      }
    }
  }
  EXPECT_GT(points, 40);
}

// Images of a sweep, each drawn with lines of equal light in five rows about the true row.
TEST(LensSection, ScanFindsTheReferenceThroughTheLenses) {
  constexpr int kStep = 8;
  const rig::Rig ideal = rig::load_rig("light-section");
  const rig::Calibration calibration = distorted_calibration(ideal, kDistortions[0]);
  rig::Rig rig = rig::rig_of(calibration, ideal);
  rig.measure.mode = model::Mode::grey;
  const LensWorld world(calibration);
  const auto surface = [&](double y, double /*x*/) { return rig.plane_z_mm - 15 - 0.1 * y; };
  light_section::LineScan scan(rig, kStep);
  light_section::SweepCheck check(rig);
  for (const int line : light_section::sweep_lines(rig, kStep)) {
    std::vector<std::uint8_t> pixels(rig.camera.pixels(), 0);
    for (int c = 0; c < rig.camera.columns; c += kEvery) {
      const double row = world.camera(world.lit_point(c, surface, [&](double) { return line; }))[1];
      for (int r = 0; r < rig.camera.rows; ++r) {
        const double grey = 200 * std::exp(-0.5 * (r - row) * (r - row) / 2.25);
        pixels[static_cast<std::size_t>(r * rig.camera.columns + c)] = static_cast<std::uint8_t>(std::lround(grey));
      }
    }
    const model::ImageView image{pixels.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns};
    scan.add(line, image);
    check.add(line, image, std::to_string(line));
  }
  EXPECT_EQ(check.contradiction(), "");
  const light_section::ReferenceProfile found = scan.reference();
  EXPECT_EQ(found.valid_columns(), rig.camera.columns / kEvery);
  for (int c = 0; c < rig.camera.columns; c += kEvery) {
    const auto i = static_cast<std::size_t>(c);
    ASSERT_EQ(found.valid[i], 1) << c;
    // What the middle row sees: search along the column for the line that lights it.
    double line = found.line[i];
    const cv::Vec3d at = world.lit_point(c, surface, [&](double) { return line; });
    ASSERT_NEAR(world.camera(at)[1] + 1, rig::middle_row(rig.camera), 0.05) << c;  // of 8 bits
    ASSERT_NEAR(found.z_mm[i], at[2], 0.02) << c;
  }
}

// A rig whose tilt is 0.02 degrees wrong: its residual is taken out, and the reference itself has no difference.
TEST(LensSection, ResidualIsTakenOut) {
  const rig::Rig ideal = rig::load_rig("light-section");
  const rig::Calibration real = distorted_calibration(ideal, kDistortions[0]);
  Distortion wrong = kDistortions[0];
  wrong.turn[0] += 0.02;
  const rig::Rig rig = rig::rig_of(distorted_calibration(ideal, wrong), ideal);
  const LensWorld world(real);
  const light_section::ReferenceCurve curve = light_section::curve_of_heights(rig, level(rig, 0));
  const auto line = between(light_section::pattern_of_curve(rig, curve));
  const auto plane = [&](double, double) { return rig.plane_z_mm; };
  std::vector<double> centroids;
  for (int c = 0; c < rig.camera.columns; ++c) {
    centroids.push_back(world.camera(world.lit_point(c, plane, line))[1] + 1);
  }
  const light_section::ReferenceProfile reference = light_section::reference_of_curve(rig, curve);
  const light_section::ReferenceProfile corrected = light_section::without_residual(rig, reference, centroids);
  const Seen before = measure(rig, reference, world, plane, line);
  const Seen after = measure(rig, corrected, world, plane, line);
  for (std::size_t i = 0; i < after.points.size(); i += kEvery) {
    if (corrected.valid[i] == 0) {
      continue;
    }
    EXPECT_GT(std::abs(before.profile.dz[i]), 0.3F) << i;
    EXPECT_LT(std::abs(after.profile.dz[i]), 0.001F) << i;
  }
}

TEST(LensSection, ReferenceFileIsReadBackAndKeptApart) {
  const rig::Rig ideal = rig::load_rig("light-section");
  const rig::Rig rig = rig::rig_of(distorted_calibration(ideal, kDistortions[0]), ideal);
  std::vector<double> heights = level(rig, 0);
  heights[7] = rig::kUnknown;
  const light_section::ReferenceProfile reference =
      light_section::reference_of_curve(rig, light_section::curve_of_heights(rig, heights));
  const std::string text = light_section::reference_csv(rig, reference);
  const light_section::ReferenceProfile read = light_section::parse_reference_csv(rig, text, "r.csv");
  EXPECT_EQ(light_section::reference_csv(rig, read), text);
  EXPECT_EQ(read.valid, reference.valid);
  EXPECT_EQ(read.valid[7], 0);
  const auto message = [&](const rig::Rig& other) {
    return error_of([&] { light_section::parse_reference_csv(other, text, "r.csv"); });
  };
  EXPECT_EQ(message(ideal), "r.csv: was made for another rig: one with lenses, a laser or corrected heights");
  rig::Rig other = rig;
  other.calibration->projector.k1 += 0.001;
  EXPECT_EQ(message(other), "r.csv: was made for another rig: projector_lens.k1 is 0.08 there and 0.081 here");
}

// Where no polynomial of the kernel follows a curve, the rows end nearer to the reference.
TEST(LensSection, RowsEndWhereCurvesCannotBeFitted) {
  rig::Rig ideal = rig::load_rig("light-section");
  ideal.camera.rows = 1200;
  ideal.camera.columns = 16;
  ideal.camera.focal_length_mm = 6;
  ideal.measure.max_z_per_line_mm = 1000;
  rig::Calibration calibration = distorted_calibration(ideal, {.k1 = 0.3, .k2 = 0.4});
  calibration.camera_rows = ideal.camera.rows;
  const rig::Rig rig = rig::rig_of(calibration, ideal);
  const light_section::ReferenceProfile reference =
      light_section::reference_of_curve(rig, light_section::curve_of_heights(rig, level(rig, 0)));
  const light_section::DifferentialProfiler profiler(rig, reference);
  ASSERT_NE(profiler.curves(), nullptr);
  EXPECT_LE(profiler.curves()->fit_error_mm(), light_section::ColumnCurves::kMaxError);
  for (std::size_t c = 0; c < 16; ++c) {
    const double rows = static_cast<double>(profiler.curves()->last[c] - profiler.curves()->first[c]);
    EXPECT_GT(rows, 100) << c;
    EXPECT_LT(rows, ideal.camera.rows - 100) << c;
  }
}

// A laser on the belt in the middle row of 1000, to which the ray that is so many rows below it runs parallel.
rig::Rig laser_parallel_to(double rows_below) {
  rig::Rig rig = rig::load_any_rig("laser");
  rig.camera.rows = 1000;
  rig.calibration->camera.cy_px = 499.5;
  rig.calibration->camera.k1 = 0;
  rig.belt_pose.reset();
  rig.plane_z_mm = 500;
  const double slope = rows_below / rig.calibration->camera.fy_px;  // n · ray = 0
  const double length = std::hypot(1, slope);
  rig.light_plane = rig::RigLightPlane{{0, 1 / length, -slope / length}, -slope * rig.plane_z_mm / length};
  return rig;
}

// A laser that the image's lower rows see at a smaller and smaller angle, and at last run parallel to: the curves are
// fitted where rows see the belt and what lies about it, and the other rows give no points.
TEST(LensSection, RowsNearlyParallelToALaserGiveNoPoints) {
  const rig::Rig rig = laser_parallel_to(300);
  const double slope = 300 / rig.calibration->camera.fy_px;
  const light_section::ReferenceProfile reference = light_section::reference_of_plane(rig);
  const light_section::DifferentialProfiler profiler(rig, reference);
  ASSERT_NE(profiler.curves(), nullptr);
  const light_section::ColumnCurves& curves = *profiler.curves();
  EXPECT_LE(curves.fit_error_mm(), light_section::ColumnCurves::kMaxError);
  constexpr float kMiddle = 500.5F;  // rows from 1: here the belt is seen
  for (std::size_t c = 0; c < static_cast<std::size_t>(rig.camera.columns); ++c) {
    ASSERT_NE(curves.valid[c], 0) << c;
    EXPECT_LT(curves.first[c], kMiddle - 100) << c;
    EXPECT_GT(curves.last[c], kMiddle + 20) << c;
    EXPECT_LT(curves.last[c], kMiddle + 300) << c;
  }
  // z = d / (n · ray), by hand, at rows between them; beyond them out_of_range.
  light_section::Profile profile;
  profile.resize(rig.camera.columns);
  for (const double centroid : {420.5, 500.5, 530.5, 795.5, 900.5}) {
    model::Moments moments = moments_of(std::vector<double>(static_cast<std::size_t>(rig.camera.columns), centroid));
    profiler.profile(moments.view(), profile.view());
    const double z = slope * rig.plane_z_mm / (slope - (centroid - 500.5) / rig.calibration->camera.fy_px);
    for (std::size_t c = 0; c < static_cast<std::size_t>(rig.camera.columns); ++c) {
      const auto validity = static_cast<light_section::Validity>(profile.validity[c]);
      if (centroid > static_cast<double>(curves.last[c])) {
        ASSERT_EQ(validity, light_section::Validity::out_of_range) << centroid << " " << c;
      } else {
        ASSERT_EQ(validity, light_section::Validity::valid) << centroid << " " << c;
        ASSERT_NEAR(profile.z[c], z, 0.002) << centroid << " " << c;
      }
    }
  }
}

// A laser's light is where it is, whatever it is compared with: columns without a reference have the same points, and
// no differences. A projected pattern gives them no light that is known.
TEST(LensSection, ALaserMeasuresWithoutAReference) {
  const rig::Rig rig = rig::load_any_rig("laser");
  const light_section::ReferenceProfile whole = light_section::reference_of_plane(rig);
  light_section::ReferenceProfile part = light_section::reference_of_curve(
      rig, light_section::curve_of_heights(rig, std::vector<double>(static_cast<std::size_t>(rig.camera.columns), 12)));
  for (std::size_t i = 0; i < part.valid.size(); i += 3) {
    part.valid[i] = 0;
    part.z_mm[i] = part.offset_px[i] = part.line[i] = part.slope[i] = rig::kUnknown;
  }
  const light_section::DifferentialProfiler of_plane(rig, whole);
  const light_section::DifferentialProfiler of_part(rig, part);
  light_section::Profile on_plane, on_part;
  on_plane.resize(rig.camera.columns);
  on_part.resize(rig.camera.columns);
  int compared = 0;
  for (const double off : {-20.0, -3.3, 0.0, 7.9}) {
    std::vector<double> rows(whole.offset_px);
    std::for_each(rows.begin(), rows.end(), [&](double& row) { row += rig::middle_row(rig.camera) + off; });
    model::Moments moments = moments_of(rows);
    of_plane.profile(moments.view(), on_plane.view());
    of_part.profile(moments.view(), on_part.view());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      ASSERT_EQ(on_part.validity[i], on_plane.validity[i]) << i;
      if (on_plane.validity[i] == static_cast<std::uint8_t>(light_section::Validity::valid)) {
        EXPECT_NEAR(on_part.z[i], on_plane.z[i], 0.002);
        EXPECT_NEAR(on_part.y[i], on_plane.y[i], 0.002);
        EXPECT_EQ(std::isnan(on_part.dz[i]) && std::isnan(on_part.dx[i]) && std::isnan(on_part.dy[i]), i % 3 == 0);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 2 * rig.camera.columns);
}

// Frames of a region have points in the same rows of the sensor as whole ones, and no others, at both ends of the
// range.
TEST(LensSection, FramesOfARegionHaveTheRangeOfTheSensor) {
  constexpr std::uint32_t kM0 = 1000;
  for (const int rows_below : {300, -300}) {
    const rig::Rig rig = laser_parallel_to(rows_below);
    const light_section::DifferentialProfiler profiler(rig, light_section::reference_of_plane(rig));
    const int columns = rig.camera.columns;
    const auto count = static_cast<std::size_t>(columns);
    light_section::Profile whole;
    light_section::Profile few;
    whole.resize(columns);
    few.resize(columns);
    int points = 0;
    int out_of_range = 0;
    for (const auto& [offset, rows] : {std::pair{0, 600}, {250, 500}, {400, 600}}) {
      for (int row = offset + 10; row <= offset + rows - 10; row += 20) {
        SCOPED_TRACE(::testing::Message() << "row " << row << " of " << rows << " from " << offset << " on");
        model::Moments moments = moments_of(std::vector<double>(count, row));
        profiler.profile(moments.view(), whole.view());
        moments.m0.assign(count, kM0);
        moments.m1.assign(count, kM0 * static_cast<std::uint32_t>(row - offset));
        model::PacketHeader header{.kind = spec::kKindMoments};
        header.region_row = static_cast<std::uint16_t>(offset + 1);
        header.region_column = 1;
        model::describe_frame(header, rows, columns, {.mode = model::Mode::grey});
        std::vector<std::uint8_t> payload(model::columns_payload_bytes(header));
        model::pack_columns(header, {.moments = moments.view()}, payload.data());
        ASSERT_TRUE(profiler.profile({.header = header, .payload = payload}, few.view()));
        ASSERT_EQ(few.validity, whole.validity);
        for (std::size_t c = 0; c < count; ++c) {
          const bool valid = few.validity[c] == 0;
          (valid ? points : out_of_range) += 1;
          ASSERT_TRUE(!valid || std::abs(few.z[c] - whole.z[c]) < 1e-3F) << c;
        }
      }
    }
    EXPECT_GT(points, 1000);
    EXPECT_GT(out_of_range, 1000);
  }
}

}  // namespace
}  // namespace selfproj::test
