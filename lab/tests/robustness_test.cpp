// A2 and B4 in a world that is not ideal: what breaks a measurement is seen, and what helps helps.
#include "lab/robustness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/rig/rig.h"
#include "lab/disturbed_measurements.h"

namespace selfproj {
namespace {

const ErrorSpread& errors_of(const std::vector<WayOfMeasuring>& ways, const std::string& name) {
  return std::find_if(ways.begin(), ways.end(), [&](const auto& way) { return way.name == name; })->errors;
}

TEST(Robustness, ErrorsOfManyPoints) {
  ErrorSpread spread;
  for (int i = 1; i <= 100; ++i) {
    spread.add(i % 2 == 0 ? 0.01 * i : -0.01 * i);
  }
  spread.add(std::nan(""));
  EXPECT_EQ(spread.points(), 100U);
  EXPECT_NEAR(spread.missing(), 1 / 101.0, 1e-12);
  EXPECT_NEAR(spread.beyond(0.305), 0.7, 1e-12);
  EXPECT_NEAR(spread.quantile(0.99), 0.99, 1e-6);
  EXPECT_NEAR(spread.quantile(1), 1, 1e-6);
  EXPECT_NEAR(spread.rms(), std::sqrt(100 * 101 * 201 / 6.0 / 100) / 100, 1e-6);
}

// With all lit pixels a second reflection makes most points false; with the strongest run hardly any.
TEST(Robustness, SecondReflectionNeedsTheStrongestRun) {
  const DisturbedStairs stairs(load_rig("light-section"), 350, 4);
  const WorldFile file = load_world(kBuiltInWorld);
  const auto ideal = stairs.measure({});
  ASSERT_EQ(ideal.size(), 6U);
  for (const WayOfMeasuring& way : ideal) {
    EXPECT_GT(way.errors.points(), 1000U);
    EXPECT_LT(way.errors.rms(), 0.02) << way.name;
    EXPECT_EQ(way.errors.beyond(kFalseMm), 0) << way.name;
  }
  const World metal = world_of(file, {"gloss=painted-metal", "second-line", "defect-pixels"});
  const auto shiny = stairs.measure(metal);
  EXPECT_GT(errors_of(shiny, "grey-over").beyond(kFalseMm), 0.5);
  EXPECT_LT(errors_of(shiny, "grey-over, strongest run").beyond(kFalseMm), 0.002);
  // In mode binary all lit pixels count alike. A reflection makes columns ambiguous until the threshold lies above it.
  EXPECT_EQ(errors_of(shiny, "binary, strongest run").missing(), 1);
  Rig rig = stairs.rig();
  rig.measure.threshold = stairs.half_of_the_line(world_of(file, {"gloss=painted-metal"}));
  EXPECT_GT(rig.measure.threshold, stairs.rig().measure.threshold);
  const ErrorSpread above = errors_of(DisturbedStairs(rig, 350, 4).measure(metal), "binary, strongest run");
  EXPECT_LT(above.missing(), 0.02);
  EXPECT_EQ(above.beyond(kFalseMm), 0);
  const auto flickering = stairs.measure(world_of(file, {"flicker=30"}));
  EXPECT_GT(errors_of(flickering, "grey-over").missing(), 0.9) << "all pixels are lit";
}

// The whole experiment, as small as it can be.
TEST(Robustness, Curves) {
  std::size_t last = 0;
  std::size_t most = 0;
  const RobustnessResult result = run_robustness({.world = load_world(kBuiltInWorld),
                                                  .every = 700,
                                                  .reference_frames = 3,
                                                  .cameras = 1,
                                                  .strengths = 1,
                                                  .coarser = 8},
                                                 [&](std::size_t done, std::size_t all) {
                                                   EXPECT_EQ(done, last + 1);
                                                   last = done;
                                                   most = all;
                                                 });
  EXPECT_EQ(last, most) << "all worlds were foreseen";
  ASSERT_EQ(result.tables.size(), 5U);
  ASSERT_EQ(result.curves.size(), 2U);
  EXPECT_EQ(result.tables[0].rows.size(), 1 + 3 + 13U) << "each disturbance at its default";
  EXPECT_EQ(nlohmann::json::parse(result.data)["curves"].size(), 2 * (1 + 3 + 13U));
  EXPECT_EQ(result.page.plots.size(), 26U);
}

}  // namespace
}  // namespace selfproj
