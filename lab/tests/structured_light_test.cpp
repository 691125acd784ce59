// B4 in simulation, with the reference scanned by Gray codes: all goals are reached. B7 and B8 in a few depth images.
#include "lab/structured_light.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/rig/rig.h"
#include "lab/cuboids.h"
#include "lab/moving_things.h"
#include "sim/scene/virtual_scan.h"
#include "tests/host/light_section/seen_surface.h"

namespace selfproj {
namespace {

// A depth image's figures of one thing, without those that no test needs.
struct Row {
  double frame, valid, height_mm, true_height_mm, columns, true_columns;
};

// "thing","method",frame,time,valid,rms,height,true height,rows,true rows,columns,true columns
std::vector<Row> rows_of(const std::string& series) {
  std::istringstream lines(series);
  std::string line;
  std::getline(lines, line);  // the header
  std::vector<Row> rows;
  while (std::getline(lines, line)) {
    std::istringstream cells(line.substr(line.rfind('"') + 2));
    std::vector<double> values;
    for (std::string cell; std::getline(cells, cell, ',');) {
      values.push_back(std::stod(cell));
    }
    EXPECT_EQ(values.size(), 10U) << line;
    rows.push_back({values.at(0), values.at(2), values.at(4), values.at(5), values.at(8), values.at(9)});
  }
  return rows;
}

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
  const std::vector<Row> rows = rows_of(result.series);
  for (const Row& row : rows) {
    EXPECT_GT(row.valid, 0.9) << row.frame;
    EXPECT_NEAR(row.height_mm, row.true_height_mm, 6) << row.frame;
    EXPECT_NEAR(row.true_height_mm, 29, 2) << row.frame;  // the mouse on its plate
    EXPECT_NEAR(row.columns, row.true_columns, 6) << row.frame;
  }
  EXPECT_EQ(rows.size(), static_cast<std::size_t>(2 * options.pairs));
  options.pairs = 300;
  EXPECT_THROW(run_moving("B7", options, [](std::size_t, std::size_t) {}), std::invalid_argument);
}

// The same of the hands, far above their references, on a rig with half of the pixels along each side.
TEST(MovingThings, HandsAreMeasuredInEveryDepthImage) {
  MovingOptions options;
  options.rig = test::coarse_scanner(2);
  options.scan = ScanMethod::gray_codes;
  options.first = 100;
  options.pairs = 2;
  options.strips = 1;
  const StructuredLightResult result = run_moving("B8", options, [](std::size_t, std::size_t) {});
  const std::vector<Row> rows = rows_of(result.series);
  EXPECT_EQ(rows.size(), 2U * 2 * 2) << "two hands, two methods, two depth images";
  for (const Row& row : rows) {
    EXPECT_GT(row.valid, 0.8) << row.frame;
    EXPECT_NEAR(row.height_mm, row.true_height_mm, 6) << row.frame;
  }
}

}  // namespace
}  // namespace selfproj
