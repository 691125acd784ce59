// What breaks B4 and what helps, on a scanner with a quarter of the pixels along each side.
#include "lab/cuboid_remedies.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "host/rig/rig.h"
#include "lab/disturbed_measurements.h"
#include "lab/robustness.h"
#include "sim/scene/world.h"

namespace selfproj {
namespace {

class CuboidRemedies : public testing::Test {
 protected:
  // The errors of self-projection, and then of the conventional method, under noise that no remedy was chosen on.
  [[nodiscard]] std::vector<WayOfMeasuring> with(const std::vector<std::string>& disturbances,
                                                 const CuboidSettings& settings = {}) const {
    return cuboids_.measure(world_of(file_, disturbances), settings, 11);
  }

  WorldFile file_ = load_world(kBuiltInWorld);
  DisturbedCuboids cuboids_{coarser_rig(load_rig("scanner"), 4)};
};

TEST_F(CuboidRemedies, AThresholdAboveTheSecondReflection) {
  const ErrorSpread before = with({"second-line"})[0].errors;
  const ErrorSpread after = with({"second-line"}, {.threshold = 15})[0].errors;
  EXPECT_GT(before.beyond(kFalseCodeMm), 0.01);
  EXPECT_LT(after.beyond(kFalseCodeMm), 0.005);
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

// Each setting does what it says: no point beyond the range of depths, and fewer points with more neighbours.
TEST_F(CuboidRemedies, RangeAndNeighbours) {
  const auto free = with({"second-line"});
  const auto bounded = with({"second-line"}, {.highest = 120});
  const auto among_others = with({"second-line"}, {.neighbours = 7});
  for (std::size_t way = 0; way < free.size(); ++way) {
    EXPECT_LE(bounded[way].errors.quantile(1), 136) << "120 mm above the plane to 15 mm below it";
    EXPECT_LE(bounded[way].errors.points(), free[way].errors.points());
    EXPECT_LT(among_others[way].errors.points(), free[way].errors.points());
    EXPECT_GT(among_others[way].errors.points(), free[way].errors.points() / 2);
  }
}

// A second cycle whose stripes are shifted measures the same places. If it is shifted by half a self-projected stripe,
// the mean of two differently rounded depths is closer to the truth. Conventional codes are finer than this scanner's
// lines, so their rounding stays. A cycle that was shifted without its triangulation would agree nowhere.
TEST_F(CuboidRemedies, ASecondCycleThatIsShifted) {
  constexpr std::array<double, 2> kMost{0.9, 1.02};  // of the RMS of one cycle
  const auto false_points = [](const ErrorSpread& errors) {
    return std::lround(errors.beyond(kFalseCodeMm) * static_cast<double>(errors.points()));
  };
  const auto one = with({});
  for (const double shift : {1.0, 3.0}) {
    const auto two = with({}, {.shift = shift});
    for (std::size_t way = 0; way < one.size(); ++way) {
      const ErrorSpread& before = one[way].errors;
      const ErrorSpread& after = two[way].errors;
      EXPECT_LT(after.rms(), kMost.at(way) * before.rms()) << one[way].name << ", " << shift;
      EXPECT_LE(false_points(after), false_points(before)) << one[way].name << ", " << shift;
      EXPECT_LE(after.points(), before.points()) << one[way].name << ", " << shift;
      EXPECT_GT(10 * after.points(), 9 * before.points()) << one[way].name << ", " << shift;
    }
  }
}

TEST(CuboidRemediesTable, HasEachRemedyForBothWays) {
  std::size_t last = 0;
  std::size_t most = 0;
  const DisturbedCuboids cuboids(coarser_rig(load_rig("scanner"), 8));
  const auto count = [&](std::size_t done, std::size_t all) {
    EXPECT_EQ(done, last + 1);
    last = done;
    most = all;
  };
  const auto tried = try_cuboid_remedies(cuboids, load_world(kBuiltInWorld), 1, count);
  EXPECT_EQ(last, most) << "all measurements were foreseen";
  const ReportTable table = remedies_table(tried, 1);
  ASSERT_EQ(table.rows.size(), 26U);
  EXPECT_EQ(table.rows[0][0], "second-line");
  for (const auto& row : table.rows) {
    EXPECT_EQ(row.size(), table.header.size());
  }
}

}  // namespace
}  // namespace selfproj
