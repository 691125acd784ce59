// Random small images whose columns have runs, gaps and ties, and random settings for them.
#ifndef SELFPROJ_TESTS_SUPPORT_RANDOM_RUNS_H
#define SELFPROJ_TESTS_SUPPORT_RANDOM_RUNS_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/model/column_runs.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

struct RandomRuns {
  std::vector<std::uint8_t> pixels;
  model::ImageView image;  // of `pixels`
  model::Measure measure;  // with Select::strongest

  // Up to 70 columns and 40 rows, now and then up to 1100 columns or 1023 rows. Pixels have few values, so that equal
  // runs are frequent.
  explicit RandomRuns(std::uint64_t seed) {
    Random random(seed);
    const int rows = random.between(1, random.chance(2) ? spec::kMaxRows : 40);
    const int columns = random.between(1, random.chance(2) ? 1100 : 70);
    const int stride = columns + random.between(0, 3);
    measure = {.mode = static_cast<model::Mode>(random.between(0, 2)),
               .threshold = random.chance(20) ? 255 * random.between(0, 1) : random.between(0, 254),
               .select = model::Select::strongest,
               .gap = random.between(0, model::kMaxGap)};
    if (random.chance(50)) {
      measure.window = {random.between(0, rows + 2), random.chance(30) ? 0 : random.between(0, rows + 2)};
    }
    const int lit_percent = random.between(5, 95);
    const int values = random.chance(50) ? 2 : 255 - measure.threshold;  // of lit pixels
    pixels.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(stride));
    for (std::uint8_t& pixel : pixels) {
      const bool lit = measure.threshold < 255 && random.chance(lit_percent);
      const int value = lit ? measure.threshold + random.between(1, std::min(values, 255 - measure.threshold))
                            : random.between(0, measure.threshold);
      pixel = static_cast<std::uint8_t>(value);
    }
    image = {pixels.data(), rows, columns, stride};
  }
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_RANDOM_RUNS_H
