// Runs the experiments on a few of their frames: all goals are reached, and the checks can fail.
#include "sim/experiment/section_experiment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "host/io/user_error.h"
#include "host/rig/rig.h"

namespace selfproj {
namespace {

SectionResult run(const std::string& name, const SectionOptions& options) {
  return run_section_experiment(name, options, [](std::size_t, std::size_t) {});
}

SectionOptions every(int frames) {
  SectionOptions options;
  options.rig = load_rig("light-section");
  options.every = frames;
  return options;
}

TEST(Experiment, MountainIsMeasured) {
  const SectionResult result = run("A1", every(200));
  EXPECT_TRUE(result.not_reached.empty()) << result.not_reached.front();
  const SectionFigures& self = result.self_projected.modes[0];
  EXPECT_GE(self.errors.points, 5 * 512);
  EXPECT_GE(result.conventional.modes[0].range.greatest, 60);  // what self-projection saves
  EXPECT_GT(self.errors.rms, 0.001);                           // noise is on
  EXPECT_GE(result.measurement.line_peak, 120);
  EXPECT_EQ(result.tables.size(), 2U);
}

TEST(Experiment, StairsAndMarksAreMeasured) {
  const SectionResult result = run("A2", every(70));
  EXPECT_TRUE(result.not_reached.empty()) << result.not_reached.front();
  const SectionFigures& self = result.self_projected.modes[0];
  ASSERT_EQ(self.steps.size(), 3U);
  EXPECT_NEAR(self.steps[1], 39, 0.05);
  EXPECT_GT(self.errors.left_out, 100);
  EXPECT_EQ(result.conventional.rows, 160);
  EXPECT_GE(result.conventional.modes[0].range.greatest, 96);  // more than the rig's image has rows
}

// The checks can fail: with ten times the noise the error is noticed.
TEST(Experiment, NoiseIsSeen) {
  SectionOptions options = every(400);
  options.rig.imaging.read_noise *= 10;
  options.rig.measure.threshold = 100;
  const SectionResult result = run("A1", options);
  EXPECT_GT(result.self_projected.modes[0].errors.rms, 0.01);
  EXPECT_FALSE(result.not_reached.empty());
}

TEST(Experiment, OnlyThoseOfTheThesis) { EXPECT_THROW(run("A3", every(1)), UserError); }

}  // namespace
}  // namespace selfproj
