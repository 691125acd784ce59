// B4 in simulation, with the reference scanned by Gray codes: all goals are reached. B7 and B8 in a few depth images.
#include "lab/structured_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "lab/cuboids.h"
#include "lab/gray_motion.h"
#include "lab/moving_things.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"
#include "sim/scene/scene.h"
#include "sim/scene/virtual_capture.h"
#include "tests/host/capture/small_scanner.h"
#include "tests/host/light_section/seen_surface.h"

namespace selfproj::test {
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
  lab::CuboidsOptions options;
  options.rig = rig::load_rig("scanner");
  options.scan = sim::ScanMethod::gray_codes;
  options.conventional_bits = {4};
  const lab::StructuredLightResult result = lab::run_cuboids(options, [](std::size_t, std::size_t) {});
  // Wrong matches beside the cuboids make the plane miss its goal; nothing else is missed.
  ASSERT_EQ(result.not_reached.size(), 1U);
  EXPECT_TRUE(result.not_reached.front().starts_with("the plane's error")) << result.not_reached.front();
  ASSERT_EQ(result.tables.size(), 7U);
  ASSERT_EQ(result.tables[5].rows.size(), 2U);
  EXPECT_EQ(result.tables[5].rows[0].size(), 8U) << "the plane is not left out";
  ASSERT_EQ(result.tables[6].rows.size(), 2U);
  EXPECT_EQ(result.tables[6].rows[1][0], "conventional, 4 bits");
  EXPECT_LT(std::stod(result.tables[6].rows[1][1]), 40) << "RMS on the plane, mm; a code is 56 mm";
  EXPECT_EQ(result.difference.rows, 512);
}

// The mouse in three depth images, on a rig with a quarter of the pixels along each side. Its codes are worth four
// times as much.
TEST(MovingThings, MouseIsMeasuredInEveryDepthImage) {
  lab::MovingOptions options;
  options.rig = coarse_scanner(4);
  options.scan = sim::ScanMethod::gray_codes;
  options.e = 2;
  options.first = 230;
  options.pairs = 3;
  options.strips = 1;
  std::size_t most = 0;
  std::size_t last = 0;
  const lab::StructuredLightResult result = lab::run_moving("B7", options, [&](std::size_t done, std::size_t all) {
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
  EXPECT_THROW(lab::run_moving("B7", options, [](std::size_t, std::size_t) {}), std::invalid_argument);
}

// The same of the hands, far above their references, on a rig with half of the pixels along each side.
TEST(MovingThings, HandsAreMeasuredInEveryDepthImage) {
  lab::MovingOptions options;
  options.rig = coarse_scanner(2);
  options.scan = sim::ScanMethod::gray_codes;
  options.first = 100;
  options.pairs = 2;
  options.strips = 1;
  const lab::StructuredLightResult result = lab::run_moving("B8", options, [](std::size_t, std::size_t) {});
  const std::vector<Row> rows = rows_of(result.series);
  EXPECT_EQ(rows.size(), 2U * 2 * 2) << "two hands, two methods, two depth images";
  for (const Row& row : rows) {
    EXPECT_GT(row.valid, 0.8) << row.frame;
    EXPECT_NEAR(row.height_mm, row.true_height_mm, 6) << row.frame;
  }
}

// Runs experiments B1 to B3 with a coarse rig and few frames.

// Rig B with so many times fewer pixels along each side.
rig::Rig small_rig(int factor = 4) { return small_scanner(factor, factor); }

lab::StructuredLightResult result_of(const std::string& name, const lab::GrayMotionOptions& options) {
  std::size_t done = 0;
  std::size_t all = 1;
  lab::StructuredLightResult result = lab::run_gray_motion(name, options, [&](std::size_t now, std::size_t of) {
    EXPECT_EQ(now, done + 1);
    done = now;
    all = of;
  });
  EXPECT_EQ(done, all) << "all images were foreseen";
  return result;
}

// A scanner with a quarter of the pixels, and a third of a turn.
TEST(GrayMotion, FistOnAnotherPath) {
  const lab::StructuredLightResult result =
      result_of("B1", {.rig = small_rig(), .render = {}, .paths = 1, .pools = 0, .frames = 120});
  ASSERT_EQ(result.page.plots.size(), 3U);  // figure 4.4
  for (const report::ReportPlot& plot : result.page.plots) {
    ASSERT_EQ(plot.traces.size(), 2U);
    for (const report::ReportTrace& trace : plot.traces) {
      EXPECT_EQ(trace.x.size(), 53U);
      EXPECT_TRUE(std::any_of(trace.y.begin(), trace.y.end(), [](double y) { return std::isfinite(y); }));
    }
  }
  const report::ReportTable& table = result.tables.at(0);
  ASSERT_EQ(table.rows.size(), 3U);
  for (const auto& row : table.rows) {
    ASSERT_EQ(row.size(), table.header.size());
  }
  const auto& drawn = table.rows[1];
  EXPECT_EQ(drawn[4], "53") << "depth images";
  EXPECT_GT(std::stod(drawn[5]), 10) << "images with half of the fist in view";
  EXPECT_LT(std::stod(drawn[7]), 20);
  EXPECT_LT(std::stod(drawn[7]), std::stod(drawn[11])) << "the filter helps";
  EXPECT_EQ(table.rows[2][7], drawn[7]);
}

// A scanner this coarse does not measure long waves of 0.02 mm, but the water that it sees has them: in the true depths
// their speed comes out within the experiment's bound.
TEST(GrayMotion, WavesAreThoseOfThreeCentimetres) {
  std::size_t last = 0;
  const lab::StructuredLightResult result =
      lab::run_gray_motion("B2", {.rig = small_rig(), .render = {}, .paths = 0, .pools = 0, .frames = 316},
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
  const report::ReportTable table =
      result_of("B3", {.rig = small_rig(2), .render = {}, .paths = 0, .pools = 0, .frames = 320}).tables.at(0);
  ASSERT_EQ(table.rows.size(), 4U);
  for (const auto& row : table.rows) {
    EXPECT_NEAR(std::stod(row[2]), std::stod(row[1]), 0.4) << row[0];
  }
}

TEST(GrayMotion, FewerFramesThanACycle) {
  EXPECT_THROW(lab::run_gray_motion("B1", {.rig = small_rig(), .render = {}, .paths = 0, .pools = 0, .frames = 8}, {}),
               std::invalid_argument);
}

// Drawn paths differ, are circles of their size and slant, and the camera sees all of the fist on them.
TEST(Fist, DrawnPathsAreSeen) {
  const rig::Rig rig = rig::load_rig("scanner");
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const sim::FistPath path = lab::drawn_path(seed);
    EXPECT_NE(path.radius, lab::drawn_path(seed + 1).radius);
    EXPECT_LT(path.rise, path.radius);
    const auto scene = sim::make_fist(rig, path);
    double high = 0;
    for (int i = 0; i < 40; ++i) {
      const sim::Cuboid box = scene->bodies(i / (40 * path.frequency))[0]->bounds();
      const sim::Point3 c = 0.5 * (box.low + box.high);
      EXPECT_NEAR(std::hypot(c.x - path.x, c.y - path.y, rig.plane_z_mm - path.height - c.z), path.radius, 1e-9);
      high = std::max(high, rig.plane_z_mm - path.height - c.z);
      for (const sim::Point3 corner : {box.low, box.high}) {
        const sim::PixelPoint at = sim::Pinhole::of_camera(rig.camera).project({corner.x, corner.y, box.low.z});
        EXPECT_GE(std::min(at.row, at.column), 0) << "seed " << seed;
        EXPECT_LE(at.column, rig.camera.columns - 1) << "seed " << seed;
        EXPECT_LE(at.row, 440) << "seed " << seed << ": a projector line is worth too much there";
      }
    }
    EXPECT_NEAR(high, path.rise, 0.01 * path.rise);
  }
}

}  // namespace
}  // namespace selfproj::test
