// Runs experiments B1 to B3 with a coarse rig and few frames.
#include "lab/gray_motion.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <stdexcept>
#include <string>

#include "host/report/report.h"
#include "host/rig/rig.h"
#include "tests/host/capture/small_scanner.h"

namespace selfproj {
namespace {

// Rig B with so many times fewer pixels along each side.
Rig small_rig(int factor = 4) { return test::small_scanner(factor, factor); }

ReportTable table_of(const std::string& name, const GrayMotionOptions& options, std::size_t table) {
  std::size_t done = 0;
  std::size_t all = 1;
  const StructuredLightResult result = run_gray_motion(name, options, [&](std::size_t now, std::size_t of) {
    EXPECT_EQ(now, done + 1);
    done = now;
    all = of;
  });
  EXPECT_EQ(done, all) << "all images were foreseen";
  return result.tables.at(table);
}

// The filter makes the centroid better on a path on which it was not chosen.
TEST(GrayMotion, FistOnAnotherPath) {
  const ReportTable others =
      table_of("B1", {.rig = small_rig(), .render = {}, .paths = 1, .pools = 0, .frames = 120}, 1);
  ASSERT_EQ(others.rows.size(), 2U);
  EXPECT_LT(std::stod(others.rows[1][3]), std::stod(others.rows[1][8]));
  EXPECT_LT(std::stod(others.rows[1][3]), 40);
}

// A scanner this coarse does not measure long waves of 0.02 mm, but the water that it sees has them: in the true depths
// their speed comes out within the experiment's bound.
TEST(GrayMotion, WavesAreThoseOfThreeCentimetres) {
  std::size_t last = 0;
  const StructuredLightResult result =
      run_gray_motion("B2", {.rig = small_rig(), .render = {}, .paths = 0, .pools = 0, .frames = 316},
                      [&](std::size_t now, std::size_t /*of*/) { last = now; });
  EXPECT_EQ(last, 16U + 316);
  ASSERT_EQ(result.tables.size(), 3U);
  const auto& rows = result.tables[0].rows;
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_NEAR(std::stod(rows[0][4]), 54.2, 2.7);
  EXPECT_GT(std::stod(rows[1][4]), 23) << "nothing on water is slower";
  EXPECT_LT(std::stod(rows[1][4]), 45) << "crests this short are slower than long waves";
  EXPECT_NE(rows[1][3], "–");
}

TEST(GrayMotion, BothSetsOfTaps) {
  const ReportTable table =
      table_of("B3", {.rig = small_rig(2), .render = {}, .paths = 0, .pools = 0, .frames = 320}, 0);
  ASSERT_EQ(table.rows.size(), 4U);
  for (const auto& row : table.rows) {
    EXPECT_NEAR(std::stod(row[2]), std::stod(row[1]), 0.4) << row[0];
  }
}

TEST(GrayMotion, FewerFramesThanACycle) {
  EXPECT_THROW(run_gray_motion("B1", {.rig = small_rig(), .render = {}, .paths = 0, .pools = 0, .frames = 8}, {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace selfproj
