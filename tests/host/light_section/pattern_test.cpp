// The drawing of patterns.
#include "host/light_section/pattern.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "selfproj/rig/rig.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

struct Line {
  double light = 0;
  double center = 0;
};
Line line_in(const images::FloatImage& pattern, int column) {
  Line line;
  for (int r = 0; r < pattern.rows; ++r) {
    line.light += static_cast<double>(pattern.row(r)[column]);
    line.center += r * static_cast<double>(pattern.row(r)[column]);
  }
  line.center /= line.light;
  return line;
}

TEST(Pattern, CenterAndLightDoNotDependOnTheFraction) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    rig::Rig rig = rig::load_rig("light-section");
    const bool whole = random.chance(50);
    rig.measure.line_width_px = whole ? random.between(1, 9) : 1 + random.between(0, 800) / 100.0;
    std::vector<double> lines;
    for (int i = 0; i < rig.projector.columns; ++i) {
      lines.push_back(random.between(10000, 500000) / 1000.0);
    }
    const images::FloatImage pattern = light_section::draw_pattern(rig, lines);
    ASSERT_EQ(pattern.rows, rig.projector.lines);
    for (int i = 0; i < rig.projector.columns; ++i) {
      const Line line = line_in(pattern, i);
      // Values near 1 are rounded to 6e-8, some ten of them.
      ASSERT_NEAR(line.light, rig.measure.line_width_px, 1e-6);
      const double bound = whole ? 2e-6 : 1 / (8 * rig.measure.line_width_px) + 2e-6;
      ASSERT_NEAR(line.center, lines[static_cast<std::size_t>(i)], bound);
    }
  }
}

TEST(Pattern, GapsAreDarkAndEdgesAreCut) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.projector.lines = 8;
  rig.projector.columns = 4;
  rig.measure.line_width_px = 3;
  const std::vector<double> lines = {0, std::numeric_limits<double>::quiet_NaN(), 7.5, 100};
  const images::FloatImage pattern = light_section::draw_pattern(rig, lines);
  EXPECT_EQ(pattern.row(0)[0], 1);
  EXPECT_EQ(pattern.row(1)[0], 1);
  EXPECT_EQ(pattern.row(2)[0], 0);
  EXPECT_EQ(pattern.row(5)[2], 0);
  EXPECT_EQ(pattern.row(6)[2], 0.5F + 0.0F);
  EXPECT_EQ(pattern.row(7)[2], 1);
  for (int r = 0; r < 8; ++r) {
    EXPECT_EQ(pattern.row(r)[1], 0);
    EXPECT_EQ(pattern.row(r)[3], 0);
  }
  EXPECT_THROW(light_section::draw_pattern(rig, std::vector<double>(3)), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
