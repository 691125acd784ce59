// B4 in simulation, with the reference scanned by Gray codes: all goals are reached. B7 in a few depth images.
#include "sim/experiment/structured_light.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/rig/rig.h"
#include "sim/experiment/cuboids.h"
#include "sim/experiment/moving_things.h"
#include "sim/scene/virtual_scan.h"
#include "tests/host/light_section/seen_surface.h"

namespace selfproj {
namespace {

TEST(StructuredLight, CuboidsAreMeasured) {
  CuboidsOptions options;
  options.rig = load_rig("scanner");
  options.scan = ScanMethod::gray_codes;
  options.conventional_bits = {4};
  const StructuredLightResult result = run_cuboids(options, [](std::size_t, std::size_t) {});
  EXPECT_TRUE(result.not_reached.empty()) << result.not_reached.front();
  ASSERT_EQ(result.tables.size(), 6U);
  ASSERT_EQ(result.tables[5].rows.size(), 2U);
  EXPECT_EQ(result.tables[5].rows[0].size(), 8U) << "the plane is not left out";
  EXPECT_EQ(result.difference.rows, 512);
}

// The mouse in three depth images, on a rig with a quarter of the pixels along each side. Its codes are worth four
// times as much.
TEST(MovingThings, MouseIsMeasuredInEveryDepthImage) {
  MovingOptions options;
  options.rig = test::coarse_scanner(4);
  options.scan = ScanMethod::gray_codes;
  options.e = 2;
  options.first = 230;
  options.pairs = 3;
  options.strips = 1;
  std::size_t most = 0;
  std::size_t last = 0;
  const StructuredLightResult result = run_moving("B7", options, [&](std::size_t done, std::size_t all) {
    ASSERT_EQ(done, last + 1);
    last = done;
    most = all;
  });
  EXPECT_EQ(last, most) << "all images were foreseen";
  ASSERT_EQ(result.tables.size(), 2U);
  EXPECT_EQ(result.tables[0].rows.size(), 2U);
  EXPECT_EQ(result.page.pictures.size(), 2U);
  EXPECT_EQ(result.page.plots.size(), 6U);
  std::istringstream lines(result.series);
  std::string line;
  std::getline(lines, line);
  int rows = 0;
  while (std::getline(lines, line)) {
    // "mouse","method",frame,time,valid,rms,height,true height,...
    std::istringstream cells(line.substr(line.rfind('"') + 2));
    std::vector<double> values;
    for (std::string cell; std::getline(cells, cell, ',');) {
      values.push_back(std::stod(cell));
    }
    ASSERT_EQ(values.size(), 10U) << line;
    EXPECT_GT(values[2], 0.9) << line;
    EXPECT_NEAR(values[4], values[5], 6) << line;
    EXPECT_NEAR(values[5], 29, 2) << line;  // the mouse on its plate
    EXPECT_NEAR(values[8], values[9], 6) << line;
    ++rows;
  }
  EXPECT_EQ(rows, 2 * options.pairs);
  options.pairs = 300;
  EXPECT_THROW(run_moving("B7", options, [](std::size_t, std::size_t) {}), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj
