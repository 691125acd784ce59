// A2 and B4 in a world that is not ideal: what breaks a measurement is seen, and what helps helps.
#include "lab/robustness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "lab/cuboid_remedies.h"
#include "lab/disturbed_measurements.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/world.h"

namespace selfproj::test {
namespace {

const lab::ErrorSpread& errors_of(const std::vector<lab::WayOfMeasuring>& ways, const std::string& name) {
  return std::find_if(ways.begin(), ways.end(), [&](const auto& way) { return way.name == name; })->errors;
}

TEST(Robustness, ErrorsOfManyPoints) {
  lab::ErrorSpread spread;
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
  const lab::DisturbedStairs stairs(rig::load_rig("light-section"), 350, 4);
  const sim::WorldFile file = sim::load_world(sim::kBuiltInWorld);
  const auto ideal = stairs.measure({});
  ASSERT_EQ(ideal.size(), 6U);
  for (const lab::WayOfMeasuring& way : ideal) {
    EXPECT_GT(way.errors.points(), 1000U);
    EXPECT_LT(way.errors.rms(), 0.02) << way.name;
    EXPECT_EQ(way.errors.beyond(lab::kFalseMm), 0) << way.name;
  }
  const sim::World metal = sim::world_of(file, {"gloss=painted-metal", "second-line", "defect-pixels"});
  const auto shiny = stairs.measure(metal);
  EXPECT_GT(errors_of(shiny, "grey-over").beyond(lab::kFalseMm), 0.5);
  EXPECT_LT(errors_of(shiny, "grey-over, strongest run").beyond(lab::kFalseMm), 0.002);
  // In mode binary all lit pixels count alike. A reflection makes columns ambiguous until the threshold lies above it.
  EXPECT_EQ(errors_of(shiny, "binary, strongest run").missing(), 1);
  rig::Rig rig = stairs.rig();
  rig.measure.threshold = stairs.half_of_the_line(sim::world_of(file, {"gloss=painted-metal"}));
  EXPECT_GT(rig.measure.threshold, stairs.rig().measure.threshold);
  const lab::ErrorSpread above = errors_of(lab::DisturbedStairs(rig, 350, 4).measure(metal), "binary, strongest run");
  EXPECT_LT(above.missing(), 0.02);
  EXPECT_EQ(above.beyond(lab::kFalseMm), 0);
  const auto flickering = stairs.measure(sim::world_of(file, {"flicker=30"}));
  EXPECT_GT(errors_of(flickering, "grey-over").missing(), 0.9) << "all pixels are lit";
}

// The whole experiment, as small as it can be.
TEST(Robustness, Curves) {
  std::size_t last = 0;
  std::size_t most = 0;
  const lab::RobustnessResult result = lab::run_robustness({.world = sim::load_world(sim::kBuiltInWorld),
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

// What breaks B4 and what helps, on a scanner with a quarter of the pixels along each side.
class CuboidRemedies : public testing::Test {
 protected:
  // The errors of self-projection, and then of the conventional method, under noise that no remedy was chosen on.
  [[nodiscard]] std::vector<lab::WayOfMeasuring> with(const std::vector<std::string>& disturbances,
                                                      const lab::CuboidSettings& settings = {}) const {
    return cuboids_.measure(sim::world_of(file_, disturbances), settings, 11);
  }

  sim::WorldFile file_ = sim::load_world(sim::kBuiltInWorld);
  lab::DisturbedCuboids cuboids_{lab::coarser_rig(rig::load_rig("scanner"), 4)};
};

TEST_F(CuboidRemedies, AThresholdAboveTheSecondReflection) {
  const lab::ErrorSpread before = with({"second-line"})[0].errors;
  const lab::ErrorSpread after = with({"second-line"}, {.threshold = 15})[0].errors;
  EXPECT_GT(before.beyond(lab::kFalseCodeMm), 0.01);
  EXPECT_LT(after.beyond(lab::kFalseCodeMm), 0.005);
  EXPECT_LT(after.missing(), before.missing());
}

TEST_F(CuboidRemedies, AShorterExposureOfFullPixels) {
  const auto ideal = with({});
  const auto before = with({"saturation=8"});
  const auto after = with({"saturation=8"}, {.exposure = 0.25});
  for (std::size_t way = 0; way < ideal.size(); ++way) {
    EXPECT_GT(before[way].errors.missing(), ideal[way].errors.missing() + 0.1) << ideal[way].name;
    EXPECT_LT(after[way].errors.missing(), ideal[way].errors.missing() + 0.02) << ideal[way].name;
  }
}

// No point lies beyond the range of depths.
TEST_F(CuboidRemedies, ARangeOfDepths) {
  const auto free = with({"second-line"});
  const auto bounded = with({"second-line"}, {.highest = 120});
  for (std::size_t way = 0; way < free.size(); ++way) {
    EXPECT_LE(bounded[way].errors.quantile(1), 136) << "120 mm above the plane to 15 mm below it";
    EXPECT_LE(bounded[way].errors.points(), free[way].errors.points());
  }
}

TEST(CuboidRemediesTable, HasEachRemedyForBothWays) {
  std::size_t last = 0;
  std::size_t most = 0;
  const lab::DisturbedCuboids cuboids(lab::coarser_rig(rig::load_rig("scanner"), 8));
  const auto count = [&](std::size_t done, std::size_t all) {
    EXPECT_EQ(done, last + 1);
    last = done;
    most = all;
  };
  const auto tried = lab::try_cuboid_remedies(cuboids, sim::load_world(sim::kBuiltInWorld), 1, count);
  EXPECT_EQ(last, most) << "all measurements were foreseen";
  const report::ReportTable table = lab::remedies_table(tried, 1);
  ASSERT_EQ(table.rows.size(), 14U);
  EXPECT_EQ(table.rows[0][0], "second-line");
  for (const auto& row : table.rows) {
    EXPECT_EQ(row.size(), table.header.size());
  }
}

}  // namespace
}  // namespace selfproj::test
