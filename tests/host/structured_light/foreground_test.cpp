// Compares the foreground with its definition, pixel by pixel.

#include "selfproj/structured_light/foreground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/triangulation.h"
#include "tests/host/structured_light/random_rig.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(Foreground, IsTheCentroidOfTheDifferingPoints) {
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const rig::Rig rig = random_rig(random);
    const structured_light::PlaneTriangulation triangulation(rig, 8);
    const auto some = [&](float base) {
      std::vector<float> z(triangulation.pixels());
      for (float& value : z) {
        value = random.chance(20) ? std::nanf("") : base + static_cast<float>(uniform(random, -8, 8));
      }
      return z;
    };
    const std::vector<float> z = some(500);
    const std::vector<float> background = some(500);
    const auto least = static_cast<float>(uniform(random, 0, 20));
    double count = 0;
    double x = 0;
    double y = 0;
    double depth = 0;
    for (std::size_t i = 0; i < z.size(); ++i) {
      if (!std::isnan(z[i]) && !std::isnan(background[i]) && std::abs(z[i] - background[i]) > least) {
        const structured_light::Point3f point = triangulation.point(i, z[i]);
        count += 1;
        x += static_cast<double>(point.x);
        y += static_cast<double>(point.y);
        depth += static_cast<double>(point.z);
      }
    }
    const structured_light::Foreground found =
        structured_light::foreground_of(triangulation, z.data(), background.data(), least);
    ASSERT_EQ(found.pixels, static_cast<std::int64_t>(count));
    if (count == 0) {
      EXPECT_TRUE(std::isnan(found.x) && std::isnan(found.y) && std::isnan(found.z));
    } else {
      EXPECT_NEAR(found.x, x / count, 1e-3);
      EXPECT_NEAR(found.y, y / count, 1e-3);
      EXPECT_NEAR(found.z, depth / count, 1e-3);
    }
  }
}

// Against its definition, written out pixel by pixel.
TEST(Foreground, SteadyFilterKeepsWhatStaysAndHasNeighbours) {
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(1, 20);
    const int columns = random.between(1, 90);
    structured_light::SteadySettings settings;
    settings.min_neighbours = random.between(0, 8);
    if (random.chance(70)) {
      settings.max_change_mm = static_cast<float>(uniform(random, 0, 12));
    }
    structured_light::SteadyFilter filter(rows, columns, settings);
    EXPECT_EQ(filter.is_on(), settings.min_neighbours > 0 || std::isfinite(settings.max_change_mm));
    if (!filter.is_on()) {
      continue;
    }
    const auto some = [&] {
      std::vector<float> z(static_cast<std::size_t>(rows * columns));
      for (float& value : z) {
        value = random.chance(5) ? std::nanf("") : 500 + static_cast<float>(uniform(random, -6, 6));
      }
      return z;
    };
    const std::vector<float> background = some();
    constexpr float kLeast = 2;
    std::vector<float> before;
    for (int image = 0; image < 3; ++image) {
      const std::vector<float> z = some();
      const auto steady = [&](int r, int c) {
        if (r < 0 || c < 0 || r >= rows || c >= columns) {
          return false;
        }
        const auto i = static_cast<std::size_t>(r * columns + c);
        const bool stays = before.empty() || std::abs(z[i] - before[i]) <= settings.max_change_mm;
        return std::abs(z[i] - background[i]) > kLeast && stays;
      };
      filter.apply(z.data(), background.data(), kLeast);
      for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) {
          const auto i = static_cast<std::size_t>(r * columns + c);
          int around = 0;
          for (int dr = -1; dr <= 1; ++dr) {
            for (int dc = -1; dc <= 1; ++dc) {
              const bool other = (dr != 0 || dc != 0) && steady(r + dr, c + dc);
              around += other && std::abs(z[static_cast<std::size_t>((r + dr) * columns + c + dc)] - z[i]) <=
                                     settings.max_change_mm
                            ? 1
                            : 0;
            }
          }
          const bool kept = steady(r, c) && around >= settings.min_neighbours;
          ASSERT_EQ(std::isnan(filter.kept()[i]), !kept) << r << ", " << c;
          ASSERT_TRUE(!kept || filter.kept()[i] == z[i]);
        }
      }
      filter.remember(z.data());
      before = z;
    }
  }
  EXPECT_THROW(structured_light::SteadyFilter(4, 4, {-1, 0}), std::invalid_argument);
  EXPECT_THROW(structured_light::SteadyFilter(4, 4, {1, 9}), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
