// Runs the experiments on a few of their frames: all goals are reached, and the checks can fail.
#include "lab/section_experiment.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>

#include "lab/learned_rig.h"
#include "lab/section_measurement.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/scenes.h"

namespace selfproj::test {
namespace {

lab::SectionResult run(const std::string& name, const lab::SectionOptions& options) {
  return lab::run_section_experiment(name, options, [](std::size_t, std::size_t) {});
}

lab::SectionOptions every(int frames) {
  lab::SectionOptions options;
  options.rig = rig::load_rig("light-section");
  options.route = lab::Route::null_test;
  options.every = frames;
  return options;
}

// The thesis's way with the fewest images that determine a rig.
lab::SectionOptions learned(int frames) {
  lab::SectionOptions options = every(frames);
  options.route = lab::Route::learned;
  options.learning.board_heights_mm = {0, 24, 48};
  options.learning.plate_heights_mm = {0, 20, 40, 60};
  options.learning.every_line = 10;
  return options;
}

TEST(Experiment, MountainIsMeasured) {
  const lab::SectionResult result = run("A1", every(200));
  EXPECT_TRUE(result.not_reached.empty()) << result.not_reached.front();
  const lab::SectionFigures& self = result.self_projected.modes[0];
  EXPECT_GE(self.errors.points, 5 * 512);
  EXPECT_GE(result.conventional.modes[0].range.greatest, 60);  // what self-projection saves
  EXPECT_GT(self.errors.rms, 0.001);                           // noise is on
  EXPECT_GE(result.measurement.line_peak, 120);
  EXPECT_EQ(result.tables.size(), 2U);
}

TEST(Experiment, StairsAndMarksAreMeasured) {
  const lab::SectionResult result = run("A2", every(70));
  EXPECT_TRUE(result.not_reached.empty()) << result.not_reached.front();
  const lab::SectionFigures& self = result.self_projected.modes[0];
  ASSERT_EQ(self.steps.size(), 3U);
  EXPECT_NEAR(self.steps[1], 39, 0.05);
  EXPECT_GT(self.errors.left_out, 100);
  EXPECT_EQ(result.conventional.rows, 160);
  EXPECT_GE(result.conventional.modes[0].range.greatest, 96);  // more than the rig's image has rows
}

// The rig is another than its drawings, and only its images are known: all bounds hold, and null tests stand beside.
TEST(Experiment, ByScanAndLearnedRig) {
  const lab::SectionResult result = run("A2", learned(100));
  EXPECT_TRUE(result.not_reached.empty()) << result.not_reached.front();
  const lab::SectionFigures& self = result.self_projected.modes[0];
  ASSERT_EQ(self.steps.size(), 3U);
  EXPECT_NEAR(self.steps[0], 30, 0.03);
  EXPECT_NEAR(self.steps[1], 39, 0.03);
  EXPECT_NEAR(self.steps[2], 21, 0.03);
  EXPECT_LE(self.errors.rms, 0.03);
  EXPECT_LE(self.errors.max, 0.10);
  EXPECT_LE(self.mark_place, 0.2);
  EXPECT_GT(self.errors.points, 3000);
  EXPECT_GT(self.errors.mean, result.null_self_projected.modes[0].errors.mean - 0.03);
  EXPECT_NE(self.errors.rms, result.null_self_projected.modes[0].errors.rms);
  EXPECT_LE(result.checked_mm, 0.03);
  EXPECT_EQ(result.conventional.rows, 160);
  EXPECT_LE(result.conventional.modes[0].errors.rms, 0.03);
  EXPECT_EQ(result.tables[0].header.back(), "null test, grey-over");
}

// What the rig learned matters: with the drawings alone heights are far off.
TEST(Experiment, DrawingsAloneAreFarOff) {
  const rig::Rig drawn = rig::load_rig("light-section");
  const sim::PerturbedRig actual = sim::hidden_rig(drawn, 1);
  const sim::LightSection setup = lab::scanned_projection(drawn, actual, "stairs", {{}, 10, true}, [] {});
  const auto scene = sim::make_scene("stairs-marked", drawn);
  const lab::Measurement measurement = lab::measure(setup, *scene, {}, 200, 0, [](std::size_t) {});
  const lab::MethodFigures figures = lab::section_figures(measurement, setup, *scene, 3, {});
  EXPECT_GT(figures.modes[0].errors.rms, 0.1);
}

// The checks can fail: with ten times the noise the error is noticed.
TEST(Experiment, NoiseIsSeen) {
  lab::SectionOptions options = every(400);
  options.rig.imaging.read_noise *= 10;
  options.rig.measure.threshold = 100;
  const lab::SectionResult result = run("A1", options);
  EXPECT_GT(result.self_projected.modes[0].errors.rms, 0.01);
  EXPECT_FALSE(result.not_reached.empty());
}

TEST(Experiment, OnlyThoseOfTheThesis) { EXPECT_THROW(run("A3", every(1)), UserError); }

}  // namespace
}  // namespace selfproj::test
