// Tests the scan: θ(β) from images that were drawn from the equations.
#include "host/light_section/scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/light_section/line_finder.h"
#include "host/rig/geometry.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/rig/rig.h"
#include "tests/host/structured_light/pinhole.h"

namespace selfproj::test {
namespace {

// z of each camera column: a slope, a wave, a step.
std::vector<double> surface(const rig::Rig& rig) {
  std::vector<double> z;
  for (int i = 0; i < rig.camera.columns; ++i) {
    z.push_back(1160 - 0.05 * i + 3 * std::sin(i / 20.0) - (i > 300 ? 12 : 0));
  }
  return z;
}

// Adds a line of light, Gaussian across, at the row (from 0) `center` of a column.
void draw(images::Image& image, int column, double center, double peak) {
  for (int r = 0; r < image.rows; ++r) {
    const double light = peak * std::exp(-0.5 * (r - center) * (r - center) / (1.6 * 1.6));
    std::uint8_t& pixel = image.pixels[static_cast<std::size_t>(r * image.columns + column)];
    pixel = static_cast<std::uint8_t>(std::min(255.0, pixel + std::round(light)));
  }
}

// The camera's view of a straight line on the surface: (3.4) solved for the row.
images::Image view_of(const rig::Rig& rig, const std::vector<double>& z, double line) {
  images::Image image{rig.camera.rows, rig.camera.columns, {}};
  image.pixels.assign(static_cast<std::size_t>(image.rows * image.columns), 5);
  const double theta = rig::tan_theta(rig.projector, line);
  for (int i = 0; i < image.columns; ++i) {
    const double depth = z[static_cast<std::size_t>(i)];
    const double x = rig.projector.x_mm - (depth - rig.projector.z_mm) * theta;
    draw(image, i, camera_sees(rig.camera, {x, 0, depth}).row, 180);
  }
  return image;
}

void expect_found(const rig::Rig& rig, const std::vector<double>& z, const light_section::ReferenceProfile& found) {
  ASSERT_EQ(found.valid_columns(), rig.camera.columns);
  for (std::size_t i = 0; i < z.size(); ++i) {
    // Rounding to whole grey values moves the centroid by some thousandths of a row.
    ASSERT_NEAR(rig::line_of(rig.projector, found.tan_theta[i]), rig::line_on_middle(rig.projector, z[i]), 0.02) << i;
    ASSERT_NEAR(found.z_mm[i], z[i], 0.02 * 0.42) << i;
    ASSERT_EQ(found.offset_px[i], 0);
  }
}

TEST(LineScan, FindsTheLightPlaneOfEachColumn) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::vector<double> z = surface(rig);
  for (const int every : {1, 4}) {
    light_section::LineScan scan(rig, every);
    std::vector<int> lines = light_section::sweep_lines(rig, every);
    EXPECT_EQ(lines.size(), every == 1 ? 508U : 127U);  // a line of width 5 is whole on 2..509
    std::reverse(lines.begin(), lines.end());           // in any order
    for (const int line : lines) {
      scan.add(line, view_of(rig, z, line).view());
    }
    expect_found(rig, z, scan.reference());
  }
}

TEST(LineSightings, AreRowsFromZeroOfTheColumnsThatSeeTheLine) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::vector<double> z = surface(rig);
  constexpr int kLine = 250;
  constexpr int kDark = 200;  // column
  images::Image image = view_of(rig, z, kLine);
  for (int r = 0; r < image.rows; ++r) {
    image.pixels[static_cast<std::size_t>(r * image.columns + kDark)] = 5;
  }
  light_section::LineFinder finder(rig);
  std::vector<light_section::LineSighting> seen;
  light_section::add_sightings(finder, kLine, image.view(), seen);
  const double theta = rig::tan_theta(rig.projector, kLine);
  auto next = seen.begin();
  for (int i = 0; i < rig.camera.columns; ++i) {
    const double depth = z[static_cast<std::size_t>(i)];
    const double x = rig.projector.x_mm - (depth - rig.projector.z_mm) * theta;
    const double row = camera_sees(rig.camera, {x, 0, depth}).row;
    constexpr double kBorder = 9;  // rows: farther from the image's border the whole line is in it
    const bool whole = i != kDark && row >= kBorder && row <= rig.camera.rows - 1 - kBorder;
    const bool found = next != seen.end() && next->column == i;
    EXPECT_TRUE(found || !whole) << i;
    if (whole && found) {
      EXPECT_EQ(next->line, kLine);
      EXPECT_NEAR(next->row, row, 0.03) << i;
    }
    EXPECT_FALSE(found && i == kDark);
    next += found ? 1 : 0;
  }
  EXPECT_EQ(next, seen.end());
  EXPECT_GT(seen.size(), 50U);
}

TEST(LineScan, TheBrighterOfTwoCrossingsCounts) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::vector<double> z = surface(rig);
  light_section::LineScan scan(rig);
  for (const int line : light_section::sweep_lines(rig)) {
    images::Image image = view_of(rig, z, line);
    // A faint copy of the line 60 lines before and after it.
    for (const int ghost : {-60, 60}) {
      const images::Image other = view_of(rig, z, line + ghost);
      for (std::size_t k = 0; k < image.pixels.size(); ++k) {
        image.pixels[k] = static_cast<std::uint8_t>(std::max<int>(image.pixels[k], other.pixels[k] / 3));
      }
    }
    scan.add(line, image.view());
  }
  const light_section::ReferenceProfile found = scan.reference();
  for (std::size_t i = 0; i < z.size(); ++i) {
    ASSERT_NEAR(rig::line_of(rig.projector, found.tan_theta[i]), rig::line_on_middle(rig.projector, z[i]), 0.05) << i;
  }
}

TEST(LineScan, WhereNoLineCrossesThereIsNoReference) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::vector<double> z = surface(rig);
  light_section::LineScan scan(rig);
  const int from = static_cast<int>(rig::line_on_middle(rig.projector, z[0])) + 1;  // on one side only of column 0
  for (const int line : light_section::sweep_lines(rig)) {
    images::Image image = view_of(rig, z, line);
    for (int r = 0; r < image.rows; ++r) {
      image.pixels[static_cast<std::size_t>(r * image.columns + 7)] = 5;    // nothing at all in column 7
      image.pixels[static_cast<std::size_t>(r * image.columns + 9)] = 200;  // too much in column 9
    }
    if (line >= from) {
      scan.add(line, image.view());
    }
  }
  const light_section::ReferenceProfile found = scan.reference();
  EXPECT_EQ(found.valid[0], 0);
  EXPECT_EQ(found.valid[7], 0);
  EXPECT_EQ(found.valid[9], 0);
  EXPECT_TRUE(std::isnan(found.z_mm[7]));
  EXPECT_EQ(found.valid[200], 1);
}

// What a sweep of these lines contradicts, if its images were taken under the lines of `shown`.
std::string contradiction_of(const rig::Rig& rig, const std::vector<int>& lines, const std::vector<int>& shown,
                             const std::function<images::Image(int line)>& view) {
  light_section::SweepCheck check(rig);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    check.add(lines[i], view(shown[i]).view(), "image " + std::to_string(i));
  }
  return check.contradiction();
}

TEST(SweepCheck, ImagesInAnotherOrderAreNoticed) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::vector<double> z = surface(rig);
  for (const int every : {4, 8, 32}) {
    SCOPED_TRACE(every);
    const std::vector<int> lines = light_section::sweep_lines(rig, every);
    const std::vector<int>& right = lines;
    const auto of = [&](const std::vector<int>& shown) {
      return contradiction_of(rig, lines, shown, [&](int line) { return view_of(rig, z, line); });
    };
    EXPECT_EQ(of(right), "");
    std::vector<int> shown(right.rbegin(), right.rend());
    EXPECT_NE(of(shown).find("in the order of the lines"), std::string::npos);
    if (every > 8) {
      continue;  // so few images show the line that some other orders may be right
    }
    shown = right;
    std::shuffle(shown.begin(), shown.end(), std::mt19937(every));
    EXPECT_NE(of(shown).find("in the order of the lines"), std::string::npos);
    std::size_t seen = 0;  // in the middle of the image
    while (right[seen] < rig::line_on_middle(rig.projector, z[200])) {
      ++seen;
    }
    shown = right;
    std::swap(shown[seen], shown[seen + 1]);
    EXPECT_EQ(of(shown).rfind("image " + std::to_string(seen) + " does not show the line between", 0), 0U) << of(shown);
    shown = right;
    shown[seen] = shown[seen - 1];
    EXPECT_EQ(of(shown).rfind("image " + std::to_string(seen) + " does not show the line between", 0), 0U) << of(shown);
    shown = right;
    shown[seen] = shown[seen + 1];
    EXPECT_NE(of(shown), "");
  }
}

// Parts with edges along the columns, over which the line jumps in all of them at once, ribs and a roof.
TEST(SweepCheck, EdgesAreNoContradiction) {
  const rig::Rig rig = rig::load_rig("light-section");
  const auto look = [&](const std::function<double(double x)>& height, int line) {
    images::Image image{rig.camera.rows, rig.camera.columns, {}};
    image.pixels.assign(static_cast<std::size_t>(image.rows * image.columns), 5);
    const double theta = rig::tan_theta(rig.projector, line);
    const auto x_at = [&](double h) { return rig.projector.x_mm - (rig.plane_z_mm - h - rig.projector.z_mm) * theta; };
    double h = 40;  // the light comes from above
    while (h > 0 && height(x_at(h)) < h) {
      h -= 0.05;
    }
    for (int i = 0; i < image.columns; ++i) {
      draw(image, i, camera_sees(rig.camera, {x_at(h), 0, rig.plane_z_mm - h}).row, 180);
    }
    return image;
  };
  const std::vector<std::function<double(double)>> parts = {
      [](double x) { return std::abs(x) < 6 ? 12.0 : 0.0; }, [](double x) { return std::abs(x) < 1 ? 3.0 : 0.0; },
      [](double x) { return std::fmod(x + 100, 4) < 2 ? 2.0 : 0.0; },
      [](double x) { return std::max(0.0, 8 - std::abs(x)); }};
  for (const int every : {4, 8}) {
    for (const auto& part : parts) {
      const std::vector<int> lines = light_section::sweep_lines(rig, every);
      EXPECT_EQ(contradiction_of(rig, lines, lines, [&](int line) { return look(part, line); }), "");
    }
  }
}

TEST(SweepCheck, ASecondLineThatIsSummedIsNoticed) {
  rig::Rig rig = rig::load_rig("light-section");
  const std::vector<double> z = surface(rig);
  const std::vector<int> lines = light_section::sweep_lines(rig, 8);
  const auto with_second = [&](int line) {
    images::Image image = view_of(rig, z, line);
    const images::Image other = view_of(rig, z, line + 40);
    for (std::size_t k = 0; k < image.pixels.size(); ++k) {
      image.pixels[k] = static_cast<std::uint8_t>(std::max<int>(image.pixels[k], other.pixels[k] * 2 / 5));
    }
    return image;
  };
  EXPECT_NE(contradiction_of(rig, lines, lines, with_second).find("a second line"), std::string::npos);
  rig.measure.runs = rig::RigRuns{};
  EXPECT_EQ(contradiction_of(rig, lines, lines, with_second), "");
}

TEST(LineScan, AnyShowAndTake) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::vector<double> z = surface(rig);
  // The line is recognized from the pattern alone.
  const light_section::ReferenceProfile found =
      light_section::scan_reference(rig, [&](const images::FloatImage& pattern) {
        double light = 0;
        double sum = 0;
        for (int r = 0; r < pattern.rows; ++r) {
          light += static_cast<double>(pattern.row(r)[11]);
          sum += r * static_cast<double>(pattern.row(r)[11]);
        }
        return view_of(rig, z, sum / light);
      });
  expect_found(rig, z, found);
}

TEST(LineScan, ImagesOfAnotherSizeAreRefused) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::vector<std::uint8_t> pixels(100);
  const model::ImageView image{pixels.data(), 10, 10, 10};
  EXPECT_THROW(light_section::LineScan(rig).add(0, image), std::invalid_argument);
  EXPECT_THROW(light_section::CentroidMean(rig).add(image), std::invalid_argument);
}

TEST(CentroidMean, IsTheMeanOfGoodColumns) {
  const rig::Rig rig = rig::load_rig("light-section");
  light_section::CentroidMean mean(rig);
  for (int k = 0; k < 4; ++k) {
    images::Image image{rig.camera.rows, rig.camera.columns, {}};
    image.pixels.assign(static_cast<std::size_t>(image.rows * image.columns), 5);
    draw(image, 0, 47 + k, 180);  // rows from 0: 48, 49, 50, 51
    if (k < 2) {
      draw(image, 1, 50, 180);  // in half of them
    }
    if (k < 1) {
      draw(image, 2, 50, 180);  // in less
    }
    mean.add(image.view());
  }
  const std::vector<double> centroids = mean.centroids();
  EXPECT_NEAR(centroids[0], 49.5, 1e-9);
  EXPECT_NEAR(centroids[1], 51, 1e-9);
  EXPECT_TRUE(std::isnan(centroids[2]));
  EXPECT_TRUE(std::isnan(centroids[3]));
}

// A line that wanders in a tenth of its columns is that of good parts laid one after another; in more, of moving ones.
TEST(CentroidMean, AMovingPartIsToldFromAStandingOne) {
  const rig::Rig rig = rig::load_rig("light-section");
  for (const int moving : {0, 10, 11, 100}) {
    light_section::CentroidMean mean(rig);
    for (int k = 0; k < 4; ++k) {
      images::Image image{rig.camera.rows, rig.camera.columns, {}};
      image.pixels.assign(static_cast<std::size_t>(image.rows * image.columns), 5);
      for (int column = 0; column < 100; ++column) {
        draw(image, column, column < moving ? 45 + k : 45, 180);
      }
      mean.add(image.view());
    }
    const std::string told = mean.contradiction();
    EXPECT_EQ(told.empty(), moving <= 10) << told;
    EXPECT_EQ(told.find(std::to_string(moving) + " of 100 columns") != std::string::npos, moving > 10) << told;
  }
}

// A second line of a third of the light, and a hot pixel: the strongest run is the line, all lit pixels are not.
TEST(CentroidMean, TakesWhatTheRigSelects) {
  rig::Rig rig = rig::load_rig("light-section");
  images::Image image{rig.camera.rows, rig.camera.columns, {}};
  image.pixels.assign(static_cast<std::size_t>(image.rows * image.columns), 5);
  draw(image, 0, 40, 180);
  draw(image, 0, 70, 60);
  image.pixels[static_cast<std::size_t>(10 * image.columns)] = 255;
  const auto found = [&] {
    light_section::CentroidMean mean(rig);
    mean.add(image.view());
    return mean.centroids()[0];
  };
  EXPECT_GT(std::abs(found() - 41), 1);
  rig.measure.runs = rig::RigRuns{};
  EXPECT_NEAR(found(), 41, 1e-9);
  rig.measure.window = model::RowWindow{.first = 42, .last = 96};  // the line is cut off: its centroid would be wrong
  EXPECT_TRUE(std::isnan(found()));
}

}  // namespace
}  // namespace selfproj::test
