// Compares the fast strongest runs with the model. Integer sums are exact, so no test here has a tolerance.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/light_section/fast_moments.h"
#include "model/column_runs.h"
#include "tests/support/moments_refusals.h"
#include "tests/support/random_cases.h"
#include "tests/support/random_runs.h"

namespace selfproj::test {
namespace {

void expect_right(const ImageView& image, const Measure& measure) {
  Runs right;
  Runs found;
  right.resize(measure.select, image.columns);
  found.resize(measure.select, image.columns);
  measure_columns(image, measure, right.view());
  fast_measure_columns(image, measure, found.view());
  ASSERT_TRUE(found == right) << image.columns << " x " << image.rows << ", mode " << static_cast<int>(measure.mode)
                              << ", threshold " << measure.threshold << ", gap " << measure.gap << ", rows "
                              << measure.window.first << ".." << measure.window.last;
}

TEST(FastRuns, RandomImages) {
  for (const std::uint64_t seed : seeds(3000)) {
    SCOPED_TRACE(how_to_repeat(seed));
    RandomRuns random(seed);
    expect_right(random.image, random.measure);
    random.measure.select = Select::all;
    expect_right(random.image, random.measure);
    if (HasFatalFailure()) {
      return;
    }
  }
}

// Images of lines, of which only a few columns have something else as well: the case for which it is fast.
TEST(FastRuns, LinesWithAFewHotPixels) {
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(20, 400);
    const int columns = random.between(1, 1100);
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
    const auto at = [&](int row, int column) -> std::uint8_t& {
      return pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                    static_cast<std::size_t>(column)];
    };
    for (int column = 0; column < columns; ++column) {
      const int top = random.between(0, rows - 8);
      for (int row = top; row < top + random.between(1, 8); ++row) {
        at(row, column) = static_cast<std::uint8_t>(random.between(0, 255));
      }
      if (random.chance(3)) {
        at(random.between(0, rows - 1), column) = 255;
      }
    }
    Measure measure{.mode = static_cast<Mode>(random.between(0, 2)),
                    .threshold = random.between(0, 100),
                    .select = Select::strongest,
                    .gap = random.between(0, kMaxGap)};
    expect_right({pixels.data(), rows, columns, columns}, measure);
    measure.window = {random.between(0, rows), random.between(0, rows)};
    expect_right({pixels.data(), rows, columns, columns}, measure);
    if (HasFatalFailure()) {
      return;
    }
  }
}

// 512 runs in a column are more than 8 bits count.
TEST(FastRuns, ManyRuns) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(spec::kMaxRows) * 300, 0);
  for (std::size_t row = 0; row < spec::kMaxRows; row += 2) {
    for (std::size_t column = 0; column < 300; ++column) {
      pixels[row * 300 + column] = static_cast<std::uint8_t>(100 + column % 7);
    }
  }
  for (int gap = 0; gap <= kMaxGap; ++gap) {
    expect_right({pixels.data(), spec::kMaxRows, 300, 300},
                 {.mode = Mode::grey_over, .threshold = 50, .select = Select::strongest, .gap = gap});
  }
}

TEST(FastRuns, RefusesWhatTheModelRefuses) {
  std::vector<std::uint8_t> small(8);
  expect_refusals_of_moments([&](const ImageView& image, Mode mode, int threshold, const MomentsView& out) {
    fast_column_runs(image, {.mode = mode, .threshold = threshold, .select = Select::strongest},
                     {out, small.data(), small.data()});
  });
}

}  // namespace
}  // namespace selfproj::test
