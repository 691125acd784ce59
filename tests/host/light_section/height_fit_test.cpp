// Tests the calibration of heights on points and pixels written out apart from the host's geometry: a rig that nobody
// knows, whose camera leans against the belt, believed to be the built-in one.
#include "host/light_section/height_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/rig/height_correction.h"
#include "selfproj/rig/optics.h"
#include "selfproj/rig/rig.h"
#include "tests/host/light_section/lens_world.h"

namespace selfproj::test {
namespace {

constexpr double kNoise = 0.02;  // rows

// A perturbed rig, and a belt that leans against its camera by some degrees (along rows, along columns).
struct HiddenRig {
  explicit HiddenRig(const Distortion& distortion)
      : believed(rig::load_rig("light-section")), world(distorted_calibration(believed, distortion)) {
    const cv::Matx33d lean = turned({0.4, -0.3, 0});
    normal = lean * cv::Vec3d(0, 0, 1);
  }

  // The plate at this height, bent by `bow` mm from its middle to its ends.
  [[nodiscard]] std::function<double(double, double)> plate(double height, double bow = 0) const {
    return [this, height, bow](double x, double y) {
      return (normal[2] * (believed.plane_z_mm + 3) - height - normal[0] * x - normal[1] * y) / normal[2] +
             bow * (x / 60) * (x / 60);
    };
  }

  // What every fourth column sees of the lines of a sweep on a surface, in these columns.
  void sweep(const std::function<double(double, double)>& surface, int first, int last,
             std::vector<light_section::LineSighting>& seen) const {
    std::mt19937 engine(7);
    std::normal_distribution<double> noise(0, kNoise);
    for (const int line : light_section::sweep_lines(believed, 16)) {
      for (int c = first; c < last; c += 5) {
        const cv::Vec3d at = world.lit_point(c, surface, [line](double) { return line; });
        const double row = world.camera(at)[1];
        if (row > 4 && row < believed.camera.rows - 5) {
          seen.push_back({static_cast<double>(line), row + noise(engine), c});
        }
      }
    }
  }
  [[nodiscard]] light_section::HeightPosition position(double height, double bow = 0) const {
    light_section::HeightPosition position{"at " + std::to_string(height), height, {}};
    sweep(plate(height, bow), 0, believed.camera.columns, position.seen);
    return position;
  }

  rig::Rig believed;
  LensWorld world;
  cv::Vec3d normal;
};

const Distortion kCase[] = {
    {.k1 = 0.1, .k2 = 0.05, .p1 = 0.001, .p2 = -0.001, .turn = {0.5, -0.5, 0.5}, .move = {5, -5, 5}},
    {.k1 = -0.1, .k2 = -0.05, .p1 = -0.001, .p2 = 0.002, .turn = {-0.5, 0.5, -0.5}, .move = {-5, 5, -5}}};

// The greatest error of the heights of single, noiseless places of a plate.
double greatest_error(const HiddenRig& hidden, const rig::Rig& rig, double height) {
  const rig::RigOptics optics(rig);
  double greatest = 0;
  for (int line = 150; line < 400; line += 25) {
    for (int c = 3; c < rig.camera.columns; c += 23) {
      const cv::Vec3d at = hidden.world.lit_point(c, hidden.plate(height), [line](double) { return line; });
      const rig::CameraPlace place{hidden.world.camera(at)[1], static_cast<double>(c)};
      if (place.row > 2 && place.row < rig.camera.rows - 3) {
        const std::optional<double> z = optics.meet(*optics.ray(place), {static_cast<double>(line), 0, 255.5});
        EXPECT_TRUE(z);
        const double found = rig.plane_z_mm - optics.corrected(place, z.value_or(0));
        greatest = std::max(greatest, std::abs(found - height));
      }
    }
  }
  return greatest;
}

std::string height_error_of(const rig::Rig& rig, const std::vector<light_section::HeightPosition>& positions,
                            const light_section::HeightSettings& settings) {
  try {
    light_section::fit_heights(rig, positions, settings);
    return "none";
  } catch (const UserError& error) {
    return error.what();
  } catch (const CheckFailed& error) {
    return std::string("check: ") + error.what();
  }
}

// The row in which a column of a rig with a laser sees the line on a plate; by search.
double laser_row(const rig::RigOptics& optics, int column, double height) {
  const auto seen = [&](double row) {
    return optics.rig().plane_z_mm - *optics.meet(*optics.ray({row, static_cast<double>(column)}), {});
  };
  double above = 0;
  double below = optics.rig().camera.rows - 1;
  const bool falls = seen(above) > seen(below);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (above + below);
    ((seen(middle) > height) == falls ? above : below) = middle;
  }
  return above;
}

// A laser whose plane is believed to be turned by a tenth of a degree about its line on the belt, and moved.
TEST(HeightFit, TiesALaserToPlates) {
  const rig::Rig truth = rig::load_any_rig("laser");
  rig::Rig believed = truth;
  const double angle = 30.1 * CV_PI / 180;
  const double distance = truth.plane_z_mm / truth.belt_pose->normal[2];  // of the belt along the axis
  believed.light_plane = rig::RigLightPlane{{0, -std::cos(angle), std::sin(angle)}, distance * std::sin(angle) + 0.1};
  const rig::RigOptics optics(truth);
  std::mt19937 engine(7);
  std::normal_distribution<double> noise(0, kNoise);
  std::vector<light_section::HeightPosition> positions;
  for (const double height : {0.0, 10.0, 20.0, 30.0}) {
    light_section::HeightPosition position{"at " + std::to_string(height), height, {}};
    for (const double image : {0.0, 1.0}) {
      for (int c = 0; c < truth.camera.columns; c += 3) {
        position.seen.push_back({image, laser_row(optics, c, height) + noise(engine), c});
      }
    }
    positions.push_back(position);
  }
  const light_section::HeightFit fit = light_section::fit_heights(believed, positions, {});
  EXPECT_GT(std::abs(fit.levels.back().before_mean_mm), 0.03);
  const rig::RigOptics found(fit.rig);
  for (const double height : {0.0, 5.0, 17.0, 30.0}) {
    for (int c = 5; c < truth.camera.columns; c += 30) {
      const rig::CameraPlace place{laser_row(optics, c, height), static_cast<double>(c)};
      const double z = found.corrected(place, *found.meet(*found.ray(place), {}));
      EXPECT_NEAR(fit.rig.plane_z_mm - z, height, 0.02) << c;
    }
  }
  for (light_section::HeightPosition& position : positions) {
    position.height_mm *= 1.1;
  }
  EXPECT_NE(height_error_of(believed, positions, {}).find("check: heights: the rig sees 0.9"), std::string::npos);
}

TEST(HeightFit, RemovesWhatTheGeometryLeavesOfAHiddenRig) {
  for (const Distortion& distortion : kCase) {
    const HiddenRig hidden(distortion);
    std::vector<light_section::HeightPosition> positions;
    for (const double height : {0.0, 10.0, 20.0, 30.0, 40.0}) {
      positions.push_back(hidden.position(height));
    }
    const light_section::HeightFit fit = light_section::fit_heights(hidden.believed, positions, {});
    for (const double height : {0.0, 5.0, 17.0, 33.0, 40.0}) {
      EXPECT_LT(greatest_error(hidden, fit.rig, height), 0.01) << height;
    }
    EXPECT_FALSE(fit.rig.belt_pose);  // pinholes do not tell it
    // Single centroids have the noise that was put in: a row is 0.39 mm of z.
    EXPECT_NEAR(fit.rms_mm, kNoise * 0.39, 0.002);
    EXPECT_GT(fit.levels.back().before_rms_mm, 0.3);
    EXPECT_GE(fit.open_by_tolerance_mm, 0.005);
    EXPECT_LT(fit.open_by_tolerance_mm, 0.02);
    EXPECT_LT(fit.open_by_noise_mm, 0.01);
    EXPECT_EQ(rig::to_yaml(rig::parse_rig(rig::to_yaml(fit.rig), "rig")), rig::to_yaml(fit.rig));
    // A check of the finished rig finds nothing; that of a rig with 0.02 degrees more of tilt does.
    const std::vector<light_section::HeightPosition> between = {hidden.position(15)};
    EXPECT_LT(std::abs(light_section::check_heights(fit.rig, between, {}).front().mean_mm), 0.01);
    rig::Rig wrong = fit.rig;
    wrong.projector.tilt_rad += 0.02 * 3.14159 / 180;
    EXPECT_GT(std::abs(light_section::check_heights(wrong, between, {}).front().mean_mm), 0.2);
  }
}

// What the tolerance of the levels leaves open: each level is off by it, and what that moves a height by adds up
// whatever its sign. Here each level is moved a little and the fit is done again, with as many terms.
TEST(HeightFit, ToldErrorCoversLevelsThatAreOffInAnyDirection) {
  const light_section::HeightSettings settings;
  constexpr int kSteps = 8;
  constexpr double kLittle = 1e-4;  // mm; for all of the tolerance it could choose other terms
  const HiddenRig hidden(kCase[0]);
  std::vector<light_section::HeightPosition> positions;
  for (const double height : {0.0, 10.0, 20.0, 30.0}) {
    positions.push_back(hidden.position(height));
  }
  const light_section::HeightFit fit = light_section::fit_heights(hidden.believed, positions, settings);
  const rig::RigHeights& range = fit.rig.heights.value();
  std::vector<rig::Rig> moved;
  for (light_section::HeightPosition& position : positions) {
    position.height_mm += kLittle;
    moved.push_back(light_section::fit_heights(hidden.believed, positions, settings).rig);
    position.height_mm -= kLittle;
    ASSERT_EQ(moved.back().heights.value().corrections_mm.size(), range.corrections_mm.size());
  }
  const auto height_of = [](const rig::Rig& rig, double row, double column, double z) {
    const double height = rig.plane_z_mm - z;
    return height + rig::HeightCorrection(rig.camera, rig.heights.value()).at(row, column, height);
  };
  double greatest = 0;
  for (int r = 0; r <= kSteps; ++r) {
    for (int c = 0; c <= kSteps; ++c) {
      for (int h = 0; h <= kSteps; ++h) {
        const double row = r * (fit.rig.camera.rows - 1.0) / kSteps;
        const double column = c * (fit.rig.camera.columns - 1.0) / kSteps;
        const double z = fit.rig.plane_z_mm - (range.min_mm + h * (range.max_mm - range.min_mm) / kSteps);
        double sum = 0;
        for (const rig::Rig& other : moved) {
          sum += std::abs(height_of(other, row, column, z) - height_of(fit.rig, row, column, z));
        }
        greatest = std::max(greatest, settings.tolerance_mm / kLittle * sum);
      }
    }
  }
  EXPECT_GT(greatest, 1.2 * settings.tolerance_mm) << "the levels pull in one direction only: the signs are not tried";
  EXPECT_NEAR(fit.open_by_tolerance_mm, greatest, 0.02 * greatest);
}

// A reflection here and there, some rows from the line.
TEST(HeightFit, StraySightingsAreLeftOut) {
  const HiddenRig hidden(kCase[0]);
  std::vector<light_section::HeightPosition> positions;
  for (const double height : {0.0, 10.0, 20.0, 30.0}) {
    positions.push_back(hidden.position(height));
    for (std::size_t i = 0; i < positions.back().seen.size(); i += 101) {
      positions.back().seen[i].row += 5;
    }
  }
  const light_section::HeightFit fit = light_section::fit_heights(hidden.believed, positions, {});
  for (const double height : {0.0, 17.0, 30.0}) {
    EXPECT_LT(greatest_error(hidden, fit.rig, height), 0.01) << height;
  }
  EXPECT_NEAR(fit.rms_mm, kNoise * 0.39, 0.002);
}

// With the lenses known, the belt's normal is found, too.
TEST(HeightFit, FindsTheBeltOfACalibratedRig) {
  const HiddenRig hidden(kCase[0]);
  const rig::Rig rig = rig::rig_of(distorted_calibration(hidden.believed, kCase[0]), hidden.believed);
  std::vector<light_section::HeightPosition> positions;
  for (const double height : {0.0, 20.0, 40.0}) {
    positions.push_back(hidden.position(height));
  }
  const light_section::HeightFit fit = light_section::fit_heights(rig, positions, {});
  ASSERT_TRUE(fit.rig.belt_pose);
  const auto& n = fit.rig.belt_pose->normal;
  EXPECT_GT(hidden.normal.dot({n[0], n[1], n[2]}), std::cos(0.02 * 3.14159 / 180));
  EXPECT_LT(fit.correction_mm, 0.02);
  for (const double height : {0.0, 25.0, 40.0}) {
    EXPECT_LT(greatest_error(hidden, fit.rig, height), 0.01) << height;
  }
}

// The corrections would take up a factor that all heights have in common.
TEST(HeightFit, HeightsAllWrongByOneFactorAreRefused) {
  const HiddenRig hidden(kCase[0]);
  const rig::Rig calibrated = rig::rig_of(distorted_calibration(hidden.believed, kCase[0]), hidden.believed);
  const auto error = [&](const rig::Rig& rig, double factor) {
    std::vector<light_section::HeightPosition> positions;
    for (const double height : {0.0, 20.0, 40.0}) {
      positions.push_back(hidden.position(height));
      positions.back().height_mm *= factor;
    }
    return height_error_of(rig, positions, {});
  };
  EXPECT_EQ(error(hidden.believed, 1), "none");
  EXPECT_EQ(error(hidden.believed, 1.34).rfind("check: heights: the rig sees 0.7", 0), 0U)
      << error(hidden.believed, 1.34);
  EXPECT_EQ(error(calibrated, 1), "none");
  EXPECT_EQ(error(calibrated, 1.03).rfind("check: heights: the rig sees 0.971 mm for each mm", 0), 0U)
      << error(calibrated, 1.03);
}

// A block with treads side by side, moved across the columns.
TEST(HeightFit, BlockOfStepsDoesTheSame) {
  const HiddenRig hidden(kCase[0]);
  const std::vector<double> steps = {0, 21, 30, 39};
  std::vector<light_section::HeightPosition> positions;
  for (std::size_t move = 0; move < steps.size(); ++move) {
    light_section::HeightPosition position{"block " + std::to_string(move), 0, {}};
    for (std::size_t k = 0; k < steps.size(); ++k) {
      const auto column = static_cast<int>(128 * ((k + move) % steps.size()));
      hidden.sweep(hidden.plate(steps[k]), column, column + 128, position.seen);
    }
    std::stable_sort(position.seen.begin(), position.seen.end(),
                     [](const light_section::LineSighting& a, const light_section::LineSighting& b) {
                       return std::pair(a.line, a.column) < std::pair(b.line, b.column);
                     });
    positions.push_back(position);
  }
  const light_section::HeightFit fit = light_section::fit_heights(hidden.believed, positions, {.steps_mm = steps});
  for (const double height : {0.0, 10.0, 33.0}) {
    EXPECT_LT(greatest_error(hidden, fit.rig, height), 0.015) << height;
  }
}

// The corrections follow a plate that is off in part, so that the greatest error may be at a neighbour.
TEST(HeightFit, ThePlateThatIsOffIsNamed) {
  const HiddenRig hidden(kCase[0]);
  std::vector<light_section::HeightPosition> good;
  for (const double height : {0.0, 10.0, 20.0, 30.0}) {
    good.push_back(hidden.position(height));
  }
  for (const std::size_t k : {0U, 3U}) {
    std::vector<light_section::HeightPosition> positions = good;
    const light_section::HeightPosition bent = hidden.position(good[k].height_mm, 0.3);
    positions[k].seen = bent.seen;
    EXPECT_EQ(
        height_error_of(hidden.believed, positions, {}).rfind(good[k].name + ": is not flat, or not at its height", 0),
        0U)
        << height_error_of(hidden.believed, positions, {});
    const light_section::HeightPosition higher = hidden.position(good[k].height_mm + 0.3);
    positions[k].seen = higher.seen;
    EXPECT_EQ(
        height_error_of(hidden.believed, positions, {}).rfind(good[k].name + ": is not flat, or not at its height", 0),
        0U)
        << height_error_of(hidden.believed, positions, {});
  }
}

TEST(HeightFit, ThreePlatesDoNotTellWhichOfThemIsOff) {
  const HiddenRig hidden(kCase[0]);
  std::vector<light_section::HeightPosition> positions;
  for (const double height : {0.0, 10.0, 20.0}) {
    positions.push_back(hidden.position(height, height == 10 ? 0.3 : 0));
    positions.back().name = "at" + std::to_string(static_cast<int>(height));
  }
  EXPECT_EQ(
      height_error_of(hidden.believed, positions, {}),
      "heights: one position is not flat, or not at its height: at0 or at10 or at20; 0.01 mm of flatness and 0.005 "
      "mm of tolerance are allowed");
}

TEST(HeightFit, BadInputIsOneLine) {
  const HiddenRig hidden(kCase[1]);
  std::vector<light_section::HeightPosition> positions;
  for (const double height : {0.0, 10.0, 20.0, 30.0}) {
    positions.push_back(hidden.position(height));
  }
  const rig::Rig& rig = hidden.believed;
  EXPECT_EQ(height_error_of(rig, {positions[0], positions[1]}, {}),
            "heights: 2 are too few; 3 or more are needed, 5 are good");
  std::vector<light_section::HeightPosition> exchanged = positions;
  std::swap(exchanged[1].seen, exchanged[2].seen);
  EXPECT_NE(height_error_of(rig, exchanged, {}).find("are the heights in the order of the folders?"),
            std::string::npos);
  std::vector<light_section::HeightPosition> bent = positions;
  bent[2] = hidden.position(20, 0.3);
  bent[1] = hidden.position(10, -0.3);
  EXPECT_EQ(height_error_of(rig, bent, {}),
            "heights: more than one position is not flat, or not at its height; 0.01 mm of flatness and 0.005 mm of "
            "tolerance are allowed");
  std::vector<light_section::HeightPosition> dark = positions;
  dark[3].seen.resize(10);
  EXPECT_NE(height_error_of(rig, dark, {}).find("the line was found in 10 places only"), std::string::npos);
  // One place of the block shows each column at one height only.
  std::vector<light_section::HeightPosition> one = {light_section::HeightPosition{"block", 0, {}}};
  for (int k = 0; k < 4; ++k) {
    hidden.sweep(hidden.plate(10.0 * k), 128 * k, 128 * k + 128, one[0].seen);
  }
  std::stable_sort(one[0].seen.begin(), one[0].seen.end(),
                   [](const light_section::LineSighting& a, const light_section::LineSighting& b) {
                     return std::pair(a.line, a.column) < std::pair(b.line, b.column);
                   });
  EXPECT_NE(height_error_of(rig, one, {.steps_mm = {0, 10, 20, 30}}), "none");
}

}  // namespace
}  // namespace selfproj::test
