// Tests the renderer's lenses and deviating rigs against OpenCV's formulas, and that rigs without deviations give the
// images that they always gave.
#include "sim/scene/optics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/light_section/pattern.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/random.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "sim/scene/targets.h"
#include "tests/sim/level_scene.h"

namespace selfproj::test {
namespace {

// A camera or projector in OpenCV's terms: its frame has x along columns, y along rows, z along the axis.
struct CvView {
  cv::Matx33d rotation;  // from the world
  cv::Vec3d centre;
  cv::Matx33d k;
  cv::Matx<double, 1, 5> distortion;

  [[nodiscard]] cv::Vec3d in_frame(sim::Point3 p) const { return rotation * (cv::Vec3d(p.x, p.y, p.z) - centre); }

  [[nodiscard]] cv::Point2d project(sim::Point3 p) const {
    const std::vector<cv::Point3d> points{cv::Point3d(in_frame(p))};
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), k, distortion, pixels);
    return pixels[0];
  }

  // The point of the plane z that a pixel sees.
  [[nodiscard]] sim::Point3 on_plane(cv::Point2d pixel, double z) const {
    std::vector<cv::Point2d> rays;
    cv::undistortPoints(std::vector<cv::Point2d>{pixel}, rays, k, distortion, cv::noArray(), cv::noArray(),
                        {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-15});
    const cv::Vec3d along = rotation.t() * cv::Vec3d(rays[0].x, rays[0].y, 1);
    const cv::Vec3d p = centre + (z - centre[2]) / along[2] * along;
    return {p[0], p[1], p[2]};
  }
};

cv::Matx33d about(int axis, double angle) {
  cv::Vec3d v;
  v[axis] = angle;
  cv::Matx33d m;
  cv::Rodrigues(v, m);
  return m;
}

CvView view_of(const cv::Matx33d& nominal_rotation, cv::Vec3d nominal_centre, const cv::Matx33d& nominal_k,
               const sim::Perturbation& d) {
  const cv::Matx33d turn = about(2, d.rotation_rad[2]) * about(1, d.rotation_rad[1]) * about(0, d.rotation_rad[0]);
  cv::Matx33d k = nominal_k;
  k(0, 0) *= d.focal_factor;
  k(1, 1) *= d.focal_factor;
  k(0, 2) += d.column_centre_px;
  k(1, 2) += d.row_centre_px;
  return {nominal_rotation * turn.t(),
          nominal_centre + cv::Vec3d(d.shift_mm.x, d.shift_mm.y, d.shift_mm.z),
          k,
          {d.lens.k1, d.lens.k2, d.lens.p1, d.lens.p2, d.lens.k3}};
}

CvView camera_of(const rig::Rig& rig, const sim::Perturbation& d) {
  const double f = rig.camera.focal_length_mm / rig.camera.pixel_pitch_mm;
  return view_of({0, 1, 0, 1, 0, 0, 0, 0, 1}, {},
                 {f, 0, (rig.camera.columns - 1) / 2.0, 0, f, (rig.camera.rows - 1) / 2.0, 0, 0, 1}, d);
}

CvView projector_of(const rig::Rig& rig, const sim::Perturbation& d) {
  const rig::RigProjector& p = rig.projector;
  const double s = std::sin(p.tilt_rad);
  const double c = std::cos(p.tilt_rad);
  return view_of(
      {0, 1, 0, -c, 0, -s, -s, 0, c}, {p.x_mm, 0, p.z_mm},
      {p.focal_length_mm / p.column_pitch_mm, 0, (p.columns - 1) / 2.0 - p.center_yp_mm / p.column_pitch_mm, 0,
       p.focal_length_mm / p.line_pitch_mm, (p.lines - 1) / 2.0 - p.center_xp_mm / p.line_pitch_mm, 0, 0, 1},
      d);
}

sim::Perturbation large_deviation(double sign) {
  sim::Perturbation d;
  d.rotation_rad = {0.008, -0.006 * sign, 0.007};
  d.shift_mm = {4 * sign, -3, 5};
  d.focal_factor = 1 - 0.01 * sign;
  d.row_centre_px = 9;
  d.column_centre_px = -8 * sign;
  d.lens = {0.1 * sign, -0.01, 0.002, -0.0015, 0.002 * sign};
  return d;
}

TEST(BrownLens, InverseIsExactToMachinePrecision) {
  for (const double sign : {-1.0, 1.0}) {
    const sim::BrownLens lens(large_deviation(sign).lens);
    for (double x = -0.8; x <= 0.8; x += 0.1) {
      for (double y = -0.8; y <= 0.8; y += 0.1) {
        const sim::Tangents again = lens.undistorted(lens.distorted({x, y}));
        EXPECT_NEAR(again.across, x, 4e-16);
        EXPECT_NEAR(again.down, y, 4e-16);
      }
    }
  }
  const sim::BrownLens barrel({-0.3, 0, 0, 0, 0});
  EXPECT_FALSE(barrel.sees({1.2, 0}));  // folds over at 1 / sqrt(0.9)
  EXPECT_TRUE(barrel.sees({0.9, 0}));
  EXPECT_THROW(static_cast<void>(barrel.undistorted({0.8, 0})), std::invalid_argument);
}

TEST(BrownLens, StretchBoundsTheDisplacement) {
  sim::EvenNumbers random(7);
  const sim::BrownLens lens(large_deviation(1).lens);
  for (int i = 0; i < 2000; ++i) {
    const sim::Tangents a{random.within(0.6), random.within(0.6)};
    const sim::Tangents b{random.within(0.6), random.within(0.6)};
    const sim::Tangents da = lens.distorted(a);
    const sim::Tangents db = lens.distorted(b);
    const double moved = std::hypot(da.across - a.across - db.across + b.across, da.down - a.down - db.down + b.down);
    EXPECT_LE(moved, lens.stretch(0.6 * std::numbers::sqrt2) * std::hypot(a.across - b.across, a.down - b.down));
  }
}

// Camera and projector with every deviation at its bound project a grid of points where OpenCV projects them, and the
// rays of the pixels lead back.
TEST(PerturbedRig, ProjectsAsOpenCvDoes) {
  for (const std::string name : {"light-section", "scanner"}) {
    const rig::Rig rig = rig::load_rig(name);
    const double reach = name == "scanner" ? 150 : 55;
    for (const double sign : {-1.0, 1.0}) {
      const sim::Perturbation camera = large_deviation(sign);
      const sim::Perturbation projector = large_deviation(-sign);
      const sim::PerturbedRig actual = sim::perturbed_rig(rig, camera, projector);
      const CvView cv_camera = camera_of(rig, camera);
      const CvView cv_projector = projector_of(rig, projector);
      for (double x = -reach; x <= reach; x += reach / 5) {
        for (double y = -reach; y <= reach; y += reach / 5) {
          const sim::Point3 p{x, y, rig.plane_z_mm - std::abs(x) / 3};
          const auto compare = [&](const sim::Pinhole& ours, const CvView& theirs) {
            const sim::PixelPoint pixel = ours.project(p);
            const cv::Point2d expected = theirs.project(p);
            EXPECT_NEAR(pixel.row, expected.y, 1e-9);
            EXPECT_NEAR(pixel.column, expected.x, 1e-9);
            EXPECT_NEAR(ours.depth(p), theirs.in_frame(p)[2], 1e-9);
            const sim::Point3 again = ours.point_at(pixel, p.z);
            EXPECT_NEAR(again.x, p.x, 1e-9);
            EXPECT_NEAR(again.y, p.y, 1e-9);
            EXPECT_NEAR(again.z, p.z, 1e-9);
          };
          compare(actual.camera, cv_camera);
          compare(actual.projector, cv_projector);
        }
      }
    }
  }
}

// A rig file with a calibration is rendered by its full model.
TEST(PerturbedRig, OfACalibratedRigIsItsFullModel) {
  rig::Rig rig = rig::load_rig("scanner");
  rig::RigCalibration c;
  c.camera = {610, 605, 250, 260, -0.08, 0.02, 0.001, -0.002, 0.003};
  c.projector = {470, -475, 515, 380, 0.05, 0, -0.001, 0, 0};
  c.rotation_rad = {0.2, -0.03, 0.02};
  c.translation_mm = {3, -165, -280};
  rig.calibration = c;
  const sim::PerturbedRig actual(rig);
  cv::Matx33d rotation;
  cv::Rodrigues(cv::Vec3d(c.rotation_rad.data()), rotation);
  const std::array<cv::Vec3d, 2> turns{cv::Vec3d(), cv::Vec3d(c.rotation_rad.data())};
  const std::array<cv::Vec3d, 2> ways{cv::Vec3d(), cv::Vec3d(c.translation_mm.data())};
  for (const std::size_t i : {0U, 1U}) {
    const rig::RigLens& l = i == 0 ? c.camera : c.projector;
    const sim::Pinhole& ours = i == 0 ? actual.camera : actual.projector;
    for (double x = -90; x <= 90; x += 30) {
      for (double y = -90; y <= 90; y += 30) {
        std::vector<cv::Point2d> pixels;
        cv::projectPoints(std::vector<cv::Point3d>{{y, x, 540 + x / 9}}, turns.at(i), ways.at(i),
                          cv::Matx33d(l.fx_px, 0, l.cx_px, 0, l.fy_px, l.cy_px, 0, 0, 1),
                          cv::Matx<double, 1, 5>(l.k1, l.k2, l.p1, l.p2, l.k3), pixels);
        const sim::PixelPoint found = ours.project({x, y, 540 + x / 9});
        EXPECT_NEAR(found.row, pixels[0].y, 1e-9);
        EXPECT_NEAR(found.column, pixels[0].x, 1e-9);
      }
    }
  }
}

// Under a pattern whose light grows from line to line (or column to column), the grey value tells which point of the
// projector a camera pixel sees. It is the one that OpenCV's formulas give by way of the plane.
TEST(PerturbedRig, CameraPixelsSeeTheProjectorPointsOfOpenCv) {
  for (const std::string name : {"light-section", "scanner"}) {
    const rig::Rig rig = rig::load_rig(name);
    sim::Perturbation camera = large_deviation(1);
    sim::Perturbation projector = large_deviation(-1);
    const sim::PerturbedRig actual = sim::perturbed_rig(rig, camera, projector);
    const CvView cv_camera = camera_of(rig, camera);
    const CvView cv_projector = projector_of(rig, projector);
    LevelScene scene;
    const sim::PatternRenderer renderer(actual, scene, ideal());
    const auto image = [&](auto&& light) {
      images::FloatImage pattern(rig.projector.lines, rig.projector.columns);
      for (int l = 0; l < pattern.rows; ++l) {
        for (int c = 0; c < pattern.columns; ++c) {
          pattern.row(l)[c] = static_cast<float>(light(l, c));
        }
      }
      std::vector<float> pixels(rig.camera.pixels());
      renderer.render(0, sim::ProjectedLight(pattern, 0), std::span<float>(pixels));
      return pixels;
    };
    const double lines = rig.projector.lines;
    const double columns = rig.projector.columns;
    const std::vector<float> white = image([](int, int) { return 1; });
    const std::vector<float> by_line = image([&](int l, int) { return l / lines; });
    const std::vector<float> by_column = image([&](int, int c) { return c / columns; });
    int compared = 0;
    for (int row = 3; row < rig.camera.rows; row += 9) {
      for (int column = 3; column < rig.camera.columns; column += 31) {
        const auto i = static_cast<std::size_t>(row * rig.camera.columns + column);
        const sim::Point3 p = cv_camera.on_plane({column + 0.0, row + 0.0}, rig.plane_z_mm);
        const cv::Point2d seen = cv_projector.project(p);
        if (seen.y < 3 || seen.x < 3 || seen.y > lines - 4 || seen.x > columns - 4) {
          continue;
        }
        const double full = static_cast<double>(white[i]) - rig.imaging.ambient;
        const auto share = [&](const std::vector<float>& pixels) {
          return (static_cast<double>(pixels[i]) - rig.imaging.ambient) / full;
        };
        // The pixel's mean: within its area the lens's curvature moves it by far less than the tolerance of the blocks.
        EXPECT_NEAR(share(by_line) * lines, seen.y, 0.02) << name << " " << row << " " << column;
        EXPECT_NEAR(share(by_column) * columns, seen.x, 0.02) << name << " " << row << " " << column;
        ++compared;
      }
    }
    EXPECT_GT(compared, 100);
  }
}

// LineRenderer leaves out blocks that no light reaches, by bounds that must hold with lenses too. PatternRenderer has
// no such bounds.
TEST(PerturbedRig, BothRenderersSeeTheSameLine) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.conveyor.speed_mm_per_s = 0;
  sim::RenderOptions options = ideal();
  options.camera_blur = options.projector_blur = true;
  const std::unique_ptr<sim::Scene> scene = sim::make_scene("stairs", rig);
  for (const std::uint64_t seed : {3U, 4U}) {
    const sim::PerturbedRig actual = sim::hidden_rig(rig, seed);
    for (const double height : {10.0, 30.0}) {
      const sim::Point3 middle = actual.camera.point_at({48, 256}, rig.plane_z_mm - height);
      const double line = actual.projector.project(middle).row;
      const images::FloatImage pattern = light_section::draw_straight_line(rig, line);
      std::vector<float> a(rig.camera.pixels());
      std::vector<float> b(rig.camera.pixels());
      sim::LineRenderer(actual, *scene, pattern, options).render(0, std::span<float>(a));
      sim::PatternRenderer(actual, *scene, options)
          .render(0, sim::ProjectedLight(pattern, rig.imaging.projector_blur_px), b);
      double greatest = 0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        greatest = std::max(greatest, static_cast<double>(std::abs(a[i] - b[i])));
      }
      EXPECT_LT(greatest, 1.5) << seed << " " << height;  // of 200 grey values
      EXPECT_GT(*std::max_element(a.begin(), a.end()), 100) << seed << " " << height;
    }
  }
}

TEST(PerturbedRig, SeedsDrawWithinTheBoundsAndDiffer) {
  const rig::Rig rig = rig::load_rig("scanner");
  const sim::PerturbedRig nominal(rig);
  double furthest = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const sim::PerturbedRig actual = sim::hidden_rig(rig, seed);
    const sim::PerturbedRig again = sim::hidden_rig(rig, seed);
    EXPECT_EQ(actual.projector.centre().x, again.projector.centre().x);
    const sim::Point3 shift =
        (actual.projector.centre() - nominal.projector.centre()) - (actual.camera.centre() - nominal.camera.centre());
    EXPECT_LE(std::max({std::abs(shift.x), std::abs(shift.y), std::abs(shift.z)}), 2 * sim::kMaxShiftMm);
    furthest = std::max(furthest, std::abs(shift.x));
    const sim::Point3 aim = sim::middle_of_view(actual, rig.plane_z_mm);
    EXPECT_NEAR(aim.x, 0, 1e-9);
    EXPECT_NEAR(aim.y, 0, 1e-9);
    EXPECT_NEAR(actual.camera.intrinsics().row_scale / nominal.camera.intrinsics().row_scale, 1, sim::kMaxFocal);
    EXPECT_NEAR(actual.camera.intrinsics().row_0, nominal.camera.intrinsics().row_0, sim::kMaxCentrePx);
    EXPECT_LE(std::abs(actual.camera.lens().coefficients().k1), sim::kMaxDistortion.k1);
    const double angle = std::acos(std::min(1.0, sim::dot(actual.camera.axis(), nominal.camera.axis())));
    EXPECT_LE(angle, std::numbers::sqrt2 * sim::kMaxRotationDeg * std::numbers::pi / 180 + 1e-9);
  }
  EXPECT_GT(furthest, 1.2 * sim::kMaxShiftMm);
}

// ------------------------------------------------------------------ images without deviations

// FNV-1a, 64 bits.
std::uint64_t hash_of(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const std::uint8_t byte : bytes) {
    hash = (hash ^ byte) * 0x100000001b3U;
  }
  return hash;
}

// The images of rigs without deviations, noise included, are those of the version before there were any.
TEST(PerturbedRig, WithoutDeviationsEveryImageIsAsBefore) {
  const auto section = [](const std::string& name, int frame) {
    const rig::Rig rig = rig::load_rig("light-section");
    const std::unique_ptr<sim::Scene> scene = sim::make_scene(name, rig);
    const images::FloatImage line =
        light_section::draw_straight_line(rig, sim::PerturbedRig(rig).projector.project({0, 0, rig.plane_z_mm}).row);
    std::vector<std::uint8_t> pixels(rig.camera.pixels());
    sim::LineRenderer(rig, *scene, line).render(frame, std::span<std::uint8_t>(pixels));
    return hash_of(pixels);
  };
  EXPECT_EQ(section("stairs-marked", 604), 0x5dbe29f1df490808U);
  EXPECT_EQ(section("mountain", 701), 0x9f015844489ffce4U);
  const auto scanned = [](const std::string& name, int frame) {
    const rig::Rig rig = rig::load_rig("scanner");
    const std::unique_ptr<sim::Scene> scene = sim::make_scene(name, rig);
    const std::vector<images::Image> patterns = sim::gray_patterns(rig.projector, 8);
    std::vector<std::uint8_t> pixels(rig.camera.pixels());
    sim::PatternRenderer(rig, *scene)
        .render(frame, sim::project_image(rig, patterns.at(static_cast<std::size_t>(frame)), {}),
                std::span<std::uint8_t>(pixels));
    return hash_of(pixels);
  };
  EXPECT_EQ(scanned("fist", 2), 0x1e3f98e4d7c8a969U);
  EXPECT_EQ(scanned("mouse", 1), 0x3d72bf88c8405726U);
}

}  // namespace
}  // namespace selfproj::test
