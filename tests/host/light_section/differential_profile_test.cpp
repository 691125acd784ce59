// Tests the profile of a frame: known points become columns and centroids, and must come back.
#include "selfproj/light_section/differential_profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "selfproj/light_section/reference.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

rig::Rig random_rig(Random& random) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.columns = 4 * random.between(1, 300);
  rig.camera.rows = random.between(10, 512);
  rig.projector.x_mm = uniform(random, 50, 500);
  rig.projector.z_mm = uniform(random, -300, 700);
  rig.projector.tilt_rad = uniform(random, 0, 30) * kPi / 180;
  rig.measure.max_z_per_line_mm = 1e6;  // tested separately
  rig.measure.max_lit_px = 1023;
  return rig;
}

// Moments whose centroid is `centroid` to 2e-6 rows, as fine as 18 bits of M0 allow.
struct Columns {
  model::Moments moments;
  explicit Columns(int count) { moments.resize(count); }
  void set(int column, double centroid, std::uint32_t n = 6) {
    const auto i = static_cast<std::size_t>(column);
    moments.m0[i] = (1U << 18U) - 1;
    moments.m1[i] = static_cast<std::uint32_t>(std::llround(centroid * moments.m0[i]));
    moments.n[i] = n;
  }
};

// x of the light plane θ at depth z.
double x_of_plane(const rig::Rig& rig, double tan_theta, double z) {
  return rig.projector.x_mm - (z - rig.projector.z_mm) * tan_theta;
}

// The row, from 1, of the point (x, 0, z) by the pinhole.
double row_from_one(const rig::Rig& rig, double x, double z) { return camera_sees(rig.camera, {x, 0, z}).row + 1; }

TEST(DifferentialProfile, PointsComeBack) {
  for (const std::uint64_t seed : seeds(200)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const rig::Rig rig = random_rig(random);
    const int columns = rig.camera.columns;
    light_section::ReferenceProfile reference;
    reference.resize(columns);
    Columns seen(columns);
    std::vector<Point3> points;
    std::vector<Point3> met;  // of the reference
    for (int i = 0; i < columns; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double z_r = uniform(random, 900, 1300);
      const double offset = uniform(random, -1, 1);
      const double tan_beta = (i - 0.5 * (columns - 1)) * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
      const double x_r = z_r * offset * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
      reference.z_mm[k] = z_r;
      reference.offset_px[k] = offset;
      reference.tan_theta[k] = (rig.projector.x_mm - x_r) / (z_r - rig.projector.z_mm);
      reference.valid[k] = 1;
      // A point of the same light plane within the camera's image.
      double z = 0;
      double row = 0;
      do {
        z = z_r + uniform(random, -40, 40);
        row = row_from_one(rig, x_of_plane(rig, reference.tan_theta[k], z), z);
      } while (row - 3 < 1.5 || row + 3 > rig.camera.rows - 0.5);  // 6 lit pixels, none in the first or last row
      seen.set(i, row);
      points.push_back({x_of_plane(rig, reference.tan_theta[k], z), z * tan_beta, z});
      met.push_back({x_r, z_r * tan_beta, z_r});
    }
    light_section::Profile profile;
    profile.resize(columns);
    light_section::DifferentialProfiler(rig, reference).profile(seen.moments.view(), profile.view());
    for (int i = 0; i < columns; ++i) {
      const auto k = static_cast<std::size_t>(i);
      ASSERT_EQ(profile.validity[k], static_cast<std::uint8_t>(light_section::Validity::valid)) << "column " << i;
      // Floats at 1300 have steps of 1.2e-4; one row is worth at most 2.6 mm here, of which M0 gives 2e-6.
      constexpr double kShape = 1e-3;
      ASSERT_NEAR(profile.x[k], points[k].x, kShape);
      ASSERT_NEAR(profile.y[k], points[k].y, kShape);
      ASSERT_NEAR(profile.z[k], points[k].z, kShape);
      // The size of z does not affect the differences: 40 mm to 1e-6, and the centroid's 32 units of 2^-24.
      constexpr double kDifference = 3e-4;
      ASSERT_NEAR(profile.dx[k], points[k].x - met[k].x, kDifference);
      ASSERT_NEAR(profile.dy[k], points[k].y - met[k].y, kDifference);
      ASSERT_NEAR(profile.dz[k], points[k].z - met[k].z, kDifference);
    }
  }
}

// Rig A with the plane as its reference.
light_section::ReferenceProfile plane_reference(const rig::Rig& rig) {
  return light_section::reference_of_curve(
      rig, light_section::curve_of_heights(rig, std::vector<double>(static_cast<std::size_t>(rig.camera.columns))));
}

TEST(DifferentialProfile, NearerToTheCameraIsNegative) {
  const rig::Rig rig = rig::load_rig("light-section");
  const light_section::DifferentialProfiler profiler(rig, plane_reference(rig));
  Columns seen(rig.camera.columns);
  for (int i = 0; i < rig.camera.columns; ++i) {
    seen.set(i, i % 2 == 0 ? 48.5 : 51.5);
  }
  light_section::Profile profile;
  profile.resize(rig.camera.columns);
  profiler.profile(seen.moments.view(), profile.view());
  for (int i = 0; i < rig.camera.columns; i += 2) {
    const auto k = static_cast<std::size_t>(i);
    ASSERT_NEAR(profile.dz[k], 0, 1e-5);
    ASSERT_NEAR(profile.z[k], rig.plane_z_mm, 1e-3);
    // Three rows towards +x: the light of a projector at +x meets a nearer surface there. 0.39 mm a row (systems.md).
    ASSERT_NEAR(profile.dz[k + 1], -3 * 0.39, 0.02);
    ASSERT_GT(profile.dx[k + 1], 0);
    ASSERT_EQ(profile.dy[k + 1] > 0, k + 1 < 256);  // towards the middle
    ASSERT_NEAR(profile.z[k + 1] - profile.z[k], profile.dz[k + 1], 4e-4);
  }
}

TEST(DifferentialProfile, StraightLineMeasuresTheSame) {
  const rig::Rig rig = [] {
    rig::Rig r = rig::load_rig("light-section");
    r.camera.rows = 600;  // the straight line moves
    return r;
  }();
  const int columns = rig.camera.columns;
  for (const std::uint64_t seed : seeds(50)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const double line = uniform(random, 200, 300);
    const double straight = std::tan(
        rig.projector.tilt_rad + std::atan((rig.projector.center_xp_mm + (line - 255.5) * rig.projector.line_pitch_mm) /
                                           rig.projector.focal_length_mm));
    Columns with_line(columns);
    Columns with_pattern(columns);
    std::vector<double> line_on_reference;
    std::vector<double> heights;
    std::vector<double> z;
    for (int i = 0; i < columns; ++i) {
      const double z_r = rig.plane_z_mm - uniform(random, 0, 30);
      z.push_back(z_r + uniform(random, -5, 5));
      heights.push_back(rig.plane_z_mm - z_r);
      line_on_reference.push_back(row_from_one(rig, x_of_plane(rig, straight, z_r), z_r));
      with_line.set(i, row_from_one(rig, x_of_plane(rig, straight, z.back()), z.back()));
      const double own = rig.projector.x_mm / (z_r - rig.projector.z_mm);
      with_pattern.set(i, row_from_one(rig, x_of_plane(rig, own, z.back()), z.back()));
    }
    light_section::ReferenceProfile self_projected;
    self_projected.resize(columns);
    for (int i = 0; i < columns; ++i) {
      const auto k = static_cast<std::size_t>(i);
      self_projected.z_mm[k] = rig.plane_z_mm - heights[k];
      self_projected.tan_theta[k] = rig.projector.x_mm / (self_projected.z_mm[k] - rig.projector.z_mm);
      self_projected.valid[k] = 1;
    }
    light_section::Profile a;
    light_section::Profile b;
    a.resize(columns);
    b.resize(columns);
    light_section::DifferentialProfiler(rig, self_projected).profile(with_pattern.moments.view(), a.view());
    light_section::DifferentialProfiler(rig, light_section::reference_of_straight_line(rig, line, line_on_reference))
        .profile(with_line.moments.view(), b.view());
    for (int i = 0; i < columns; ++i) {
      const auto k = static_cast<std::size_t>(i);
      ASSERT_NEAR(a.z[k], z[k], 1e-3) << "column " << i;
      ASSERT_NEAR(b.z[k], z[k], 1e-3) << "column " << i;
      ASSERT_NEAR(a.dz[k], b.dz[k], 2e-4) << "column " << i;
      ASSERT_NEAR(a.dy[k], b.dy[k], 2e-4) << "column " << i;
      // x is the position of the line. It differs, and so does the difference from the reference.
      ASSERT_NEAR(b.dx[k], x_of_plane(rig, straight, z[k]) - x_of_plane(rig, straight, self_projected.z_mm[k]), 3e-4);
    }
  }
}

TEST(DifferentialProfile, SaysWhyAColumnHasNoPoint) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.measure.min_lit_px = 3;
  rig.measure.max_lit_px = 9;
  rig.camera.columns = 8;
  light_section::ReferenceProfile reference = plane_reference(rig);
  reference.valid[4] = 0;
  reference.valid[5] = 0;
  Columns seen(8);
  const std::uint32_t lit[] = {0, 1, 2, 10, 5, 0, 3, 9};
  for (int i = 0; i < 8; ++i) {
    seen.set(i, 48.5, lit[i]);
  }
  seen.moments.m0[0] = 0;
  seen.moments.m1[0] = 0;
  seen.moments.m0[5] = 0;
  light_section::Profile profile;
  profile.resize(8);
  light_section::DifferentialProfiler(rig, reference).profile(seen.moments.view(), profile.view());
  using enum light_section::Validity;
  const light_section::Validity right[] = {unlit, too_few, too_few, too_wide, no_reference, unlit, valid, valid};
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(profile.validity[i], static_cast<std::uint8_t>(right[i])) << i;
    for (const auto* values :
         {&profile.centroid, &profile.x, &profile.y, &profile.z, &profile.dx, &profile.dy, &profile.dz}) {
      EXPECT_EQ(std::isnan((*values)[i]), right[i] != valid) << i;
    }
  }
}

TEST(DifferentialProfile, OutOfRangeWhereTriangulationFails) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.columns = 4;
  rig.camera.rows = 1023;
  rig.camera.pixel_pitch_mm = 0.1;  // ±45.6 degrees
  rig.measure.max_z_per_line_mm = 1e6;
  const light_section::ReferenceProfile reference = plane_reference(rig);
  const double limit = 512 + rig.projector.x_mm / rig.projector.z_mm * 500;  // z0 tan α = x0
  Columns seen(4);
  seen.set(0, limit - 0.1);
  seen.set(1, limit + 0.1);
  seen.set(2, 512 - 500 * reference.tan_theta[2] + 1);  // the ray is parallel to the light plane at tan α = -tan θ
  seen.set(3, 512 - 500 * reference.tan_theta[2] - 1);
  light_section::Profile profile;
  profile.resize(4);
  light_section::DifferentialProfiler(rig, reference).profile(seen.moments.view(), profile.view());
  const auto bad = static_cast<std::uint8_t>(light_section::Validity::out_of_range);
  EXPECT_EQ(profile.validity, (std::vector<std::uint8_t>{0, bad, 0, bad}));

  // The change of z from one projector line to the next.
  const auto z_at = [&](double row, double line) {
    const double tan_alpha = (row - 512) * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
    const double xp = rig.projector.center_xp_mm + (line - 255.5) * rig.projector.line_pitch_mm;
    const double theta = std::tan(rig.projector.tilt_rad + std::atan(xp / rig.projector.focal_length_mm));
    return (rig.projector.x_mm + rig.projector.z_mm * theta) / (tan_alpha + theta);
  };
  const double line = projector_lights(rig.projector, {0, 0, rig.plane_z_mm}).row;
  for (const double row : {300.0, 512.0, 600.0}) {
    const double worth = z_at(row, line - 0.01) - z_at(row, line + 0.01);
    seen.set(0, row);
    for (const double share : {0.999, 1.001}) {
      rig.measure.max_z_per_line_mm = share * worth / 0.02;
      light_section::DifferentialProfiler(rig, reference).profile(seen.moments.view(), profile.view());
      EXPECT_EQ(profile.validity[0], share > 1 ? 0 : bad) << "row " << row;
    }
  }
}

// The same in plain double precision, from the printed equations (corrected).
struct Plain {
  double c, x, y, z, dx, dy, dz;
};
Plain plain_profile(const rig::Rig& rig, const light_section::ReferenceProfile& r, std::size_t i, double m0,
                    double m1) {
  Plain p{};
  p.c = m1 / m0;
  const double a = rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const double ta = a * (p.c - 0.5 * (rig.camera.rows + 1));
  const double tar = a * r.offset_px[i];
  const double tb = a * (static_cast<double>(i) - 0.5 * (rig.camera.columns - 1));
  const double t = r.tan_theta[i];
  p.z = r.z_mm[i] * (tar + t) / (ta + t);
  p.x = p.z * ta;
  p.y = p.z * tb;
  const double z_r = r.z_mm[i];
  p.dx = p.x - z_r * tar;
  p.dy = p.y - z_r * tb;
  p.dz = p.z - z_r;
  return p;
}

TEST(DifferentialProfile, PayloadsOfAllModesAgainstDoublePrecision) {
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    rig::Rig rig = rig::load_rig("light-section");
    rig.camera.columns = 4 * random.between(1, 300);
    rig.measure.max_z_per_line_mm = 1e6;
    const auto columns = static_cast<std::size_t>(rig.camera.columns);
    light_section::ReferenceProfile reference = plane_reference(rig);
    for (std::size_t i = 0; i < columns; ++i) {
      if (random.chance(50)) {
        reference.offset_px[i] = uniform(random, -40, 40);
        reference.valid[i] = 1;
        reference.z_mm[i] = uniform(random, 1000, 1200);
        reference.tan_theta[i] = uniform(random, 0.4, 0.8);
      }
    }
    const light_section::DifferentialProfiler profiler(rig, reference);
    std::vector<std::uint8_t> image = random.bytes(static_cast<std::size_t>(rig.camera.rows) * columns);
    for (std::uint8_t& pixel : image) {
      pixel = random.chance(90) ? std::uint8_t{0} : pixel;
    }
    for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
      model::Moments moments;
      moments.resize(rig.camera.columns);
      model::column_moments({image.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns}, mode,
                            rig.measure.threshold, moments.view());
      std::vector<std::uint8_t> payload(model::moments_payload_bytes(mode, rig.camera.columns));
      model::pack_moments(mode, rig.camera.columns, moments.view(), payload.data());
      light_section::Profile profile;
      light_section::Profile again;
      profile.resize(rig.camera.columns);
      again.resize(rig.camera.columns);
      profiler.profile(mode, payload.data(), profile.view());
      profiler.profile(moments.view(), again.view());
      int valid = 0;
      for (std::size_t i = 0; i < columns; ++i) {
        const auto n = static_cast<int>(moments.n[i]);
        const double c = n == 0 ? 0 : static_cast<double>(moments.m1[i]) / moments.m0[i];
        const double first = c - 0.5 * n - 1.5;  // 0 where the line leaves just the first row free
        const double last = rig.camera.rows - 0.5 - c - 0.5 * n;
        if (n > 0 && mode != model::Mode::binary && std::min(std::abs(first), std::abs(last)) < 1e-5) {
          continue;  // floats may decide either way
        }
        const light_section::Validity right = n == 0                       ? light_section::Validity::unlit
                                              : n < rig.measure.min_lit_px ? light_section::Validity::too_few
                                              : n > rig.measure.max_lit_px ? light_section::Validity::too_wide
                                              : first < 0 || last < 0      ? light_section::Validity::cut_off
                                              : reference.valid[i] == 0    ? light_section::Validity::no_reference
                                                                           : light_section::Validity::valid;
        ASSERT_EQ(profile.validity[i], static_cast<std::uint8_t>(right)) << i;
        ASSERT_EQ(again.validity[i], profile.validity[i]);
        if (right != light_section::Validity::valid) {
          continue;
        }
        ++valid;
        const Plain plain = plain_profile(rig, reference, i, moments.m0[i], moments.m1[i]);
        // The bounds of the class's comment: half units in the last place (2^-24) add up.
        ASSERT_NEAR(profile.centroid[i], plain.c, 96 * 1.5 * std::ldexp(1, -23));
        constexpr double kShape = 1300 * 4 * 1.2e-7;  // mm
        ASSERT_NEAR(profile.z[i], plain.z, kShape);
        ASSERT_NEAR(profile.x[i], plain.x, kShape);
        ASSERT_NEAR(profile.y[i], plain.y, kShape);
        const double difference = 2e-5 + 1e-6 * std::abs(plain.dz);  // mm; 2e-5 is 17e-6 rows of at most 0.7 mm each
        ASSERT_NEAR(profile.dz[i], plain.dz, difference);
        ASSERT_NEAR(profile.dx[i], plain.dx, difference);
        ASSERT_NEAR(profile.dy[i], plain.dy, difference);
        ASSERT_EQ(again.dz[i], profile.dz[i]);
        ASSERT_EQ(again.x[i], profile.x[i]);
      }
      ASSERT_TRUE(valid > 0 || columns < 16);
    }
  }
}

// Blurred lines of light with noise move over the first and the last row, beside the same lines in an image that holds
// all of them.
TEST(DifferentialProfile, LinesCutOffByTheBorder) {
  constexpr int kRows = 40;
  constexpr int kBeyond = 30;  // rows of the larger image above and below
  constexpr int kColumns = 64;
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.rows = kRows;
  rig.camera.columns = kColumns;
  rig.measure.min_lit_px = 1;
  const light_section::DifferentialProfiler profiler(rig, plane_reference(rig));
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    int valid = 0;
    int cut_off = 0;
    for (const std::uint64_t seed : seeds(100)) {
      SCOPED_TRACE(how_to_repeat(seed));
      Random random(seed);
      std::vector<std::uint8_t> large(static_cast<std::size_t>((kRows + 2 * kBeyond) * kColumns));
      for (int c = 0; c < kColumns; ++c) {
        const double middle = uniform(random, -8, kRows + 7);  // of the line; pixel centres are whole numbers
        const double half = uniform(random, 0.5, 8);
        const double blur = uniform(random, 0.3, 1.5);
        const double light = uniform(random, 60, 240);
        for (int r = -kBeyond; r < kRows + kBeyond; ++r) {
          const auto edge = [&](double at) { return std::erf((r - at) / (blur * std::sqrt(2.0))); };
          const double value = 8 + light / 2 * (edge(middle - half) - edge(middle + half)) + uniform(random, -2, 2);
          large[static_cast<std::size_t>((r + kBeyond) * kColumns + c)] =
              static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
        }
      }
      model::Moments whole;
      model::Moments seen;
      whole.resize(kColumns);
      seen.resize(kColumns);
      model::column_moments({large.data(), kRows + 2 * kBeyond, kColumns, kColumns}, mode, rig.measure.threshold,
                            whole.view());
      const std::uint8_t* image = large.data() + kBeyond * kColumns;
      model::column_moments({image, kRows, kColumns, kColumns}, mode, rig.measure.threshold, seen.view());
      light_section::Profile profile;
      profile.resize(kColumns);
      profiler.profile(seen.view(), profile.view());
      for (std::size_t c = 0; c < kColumns; ++c) {
        const auto lit = [&](int row) {
          return image[static_cast<std::size_t>(row * kColumns) + c] > rig.measure.threshold;
        };
        const bool touches = lit(0) || lit(kRows - 1);
        const bool nearly = lit(1) || lit(kRows - 2);
        if (profile.validity[c] == static_cast<std::uint8_t>(light_section::Validity::valid)) {
          ++valid;
          ASSERT_FALSE(touches) << "column " << c;
          ASSERT_EQ(seen.n[c], whole.n[c]) << "column " << c;  // nothing is missing, and so the centroid is right
          ASSERT_NEAR(static_cast<double>(profile.centroid[c]),
                      static_cast<double>(whole.m1[c]) / whole.m0[c] - kBeyond, 1e-4);
        } else if (seen.n[c] > 0) {
          ++cut_off;
          ASSERT_EQ(profile.validity[c], static_cast<std::uint8_t>(light_section::Validity::cut_off)) << "column " << c;
          ASSERT_TRUE(touches || (nearly && mode != model::Mode::binary)) << "column " << c;
        }
      }
    }
    EXPECT_GT(valid, 2000);
    EXPECT_GT(cut_off, 1000);
  }
}

TEST(DifferentialProfile, ReferenceOfAnotherWidthIsRefused) {
  const rig::Rig rig = rig::load_rig("light-section");
  light_section::ReferenceProfile reference;
  reference.resize(rig.camera.columns - 1);
  EXPECT_THROW(light_section::DifferentialProfiler(rig, reference), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
