// Compares the fast column moments and strongest runs with the models. Integer sums are exact, so no test here has a
// tolerance.
#include "selfproj/light_section/fast_moments.h"

#include <gtest/gtest.h>

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "tests/support/moments_refusals.h"
#include "tests/support/random_cases.h"
#include "tests/support/random_runs.h"

namespace selfproj::test {
namespace {

constexpr std::array kModes = {model::Mode::binary, model::Mode::grey, model::Mode::grey_over};

// A value beyond the columns of output arrays, which must still be there afterwards.
constexpr std::uint32_t kUntouched = 0xDEADBEEF;

// This file is also built for instruction sets that the processor may lack; then nothing is tested.
class FastMoments : public ::testing::Test {
 protected:
  void SetUp() override {
#ifdef SELFPROJ_TEST_NEEDS
    if (!__builtin_cpu_supports(SELFPROJ_TEST_NEEDS)) {
      GTEST_SKIP() << "this processor has no " SELFPROJ_TEST_NEEDS;
    }
#endif
  }

  // The fast moments. Checks that nothing is written beyond the columns.
  static model::Moments moments_of(const model::ImageView& image, model::Mode mode, int threshold) {
    constexpr int kGuard = 64;
    model::Moments moments;
    moments.resize(image.columns + kGuard);
    for (auto* values : {&moments.m0, &moments.m1, &moments.n}) {
      std::fill(values->begin(), values->end(), kUntouched);
    }
    light_section::fast_column_moments(image, mode, threshold, moments.view());
    for (const auto* values : {&moments.m0, &moments.m1, &moments.n}) {
      EXPECT_TRUE(std::all_of(values->end() - kGuard, values->end(), [](std::uint32_t v) { return v == kUntouched; }));
    }
    moments.resize(image.columns);
    return moments;
  }

  static void expect_right(const model::ImageView& image, model::Mode mode, int threshold) {
    model::Moments right;
    right.resize(image.columns);
    model::column_moments(image, mode, threshold, right.view());
    ASSERT_TRUE(moments_of(image, mode, threshold) == right)
        << "rows " << image.rows << ", columns " << image.columns << ", stride " << image.stride << ", mode "
        << static_cast<int>(mode) << ", threshold " << threshold;
  }
};

model::ImageView view_of(const std::vector<std::uint8_t>& pixels, int rows, int columns) {
  return {pixels.data(), rows, columns, columns};
}

std::size_t area(int rows, int columns) { return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns); }

// Sizes around the widths of vectors, of strips and of bands of strips, and around the height of a block.
constexpr std::array kColumnEdges = {1,  2,  3,  4,   5,   15,  16,  17,  18,  31,  32,   33,
                                     63, 64, 65, 127, 128, 129, 508, 511, 512, 513, 1024, 1028};
constexpr std::array kRowEdges = {1, 2, 7, 8, 9, 21, 22, 23, 43, 44, 45, 96, 127, 128, 255, 256};

TEST_F(FastMoments, EqualImagesOfEverySize) {
  for (const int rows : kRowEdges) {
    for (const int columns : kColumnEdges) {
      for (const int value : {0, 100, 101, 255}) {
        const std::vector<std::uint8_t> pixels(area(rows, columns), static_cast<std::uint8_t>(value));
        for (const model::Mode mode : kModes) {
          expect_right(view_of(pixels, rows, columns), mode, 100);
          if (HasFatalFailure()) {
            return;
          }
        }
      }
    }
  }
}

// A single lit pixel in every place of an image of several blocks, and of one of several strips.
TEST_F(FastMoments, OnePixelEverywhere) {
  constexpr int kThreshold = 17;
  constexpr std::uint8_t kValue = 200;
  for (const auto& [rows, columns] : {std::pair{47, 132}, std::pair{2, 1100}}) {
    std::vector<std::uint8_t> pixels(area(rows, columns), kThreshold);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        std::uint8_t& pixel = pixels[area(row, columns) + static_cast<std::size_t>(column)];
        pixel = kValue;
        const model::Mode mode = kModes[static_cast<std::size_t>(row + column) % kModes.size()];
        expect_right(view_of(pixels, rows, columns), mode, kThreshold);
        if (HasFatalFailure()) {
          FAIL() << "row " << row << ", column " << column;
        }
        pixel = kThreshold;
      }
    }
  }
}

// Every pixel value (one a column) under every threshold.
TEST_F(FastMoments, EveryValueAndThreshold) {
  constexpr int kRows = 3;
  constexpr int kColumns = 256;
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < kRows * kColumns; ++i) {
    pixels.push_back(static_cast<std::uint8_t>(i));
  }
  for (int threshold = 0; threshold <= 255; ++threshold) {
    for (const model::Mode mode : kModes) {
      expect_right(view_of(pixels, kRows, kColumns), mode, threshold);
    }
  }
}

// The largest image, as bright as can be: the largest sums of all.
TEST_F(FastMoments, LargestSums) {
  const std::vector<std::uint8_t> pixels(area(spec::kRowLimit, spec::kMaxColumns), 255);
  for (const model::Mode mode : kModes) {
    for (const int threshold : {0, 254, 255}) {
      expect_right(view_of(pixels, spec::kRowLimit, spec::kMaxColumns), mode, threshold);
    }
  }
}

// Neighbouring columns as different as can be: the grey modes add two of them as one word.
TEST_F(FastMoments, BrightColumnsBesideDarkOnes) {
  for (const int first_bright : {0, 1}) {
    for (const int columns : {16, 33, 64, 131}) {
      std::vector<std::uint8_t> pixels(area(spec::kRowLimit, columns), 0);
      for (int row = 0; row < spec::kRowLimit; ++row) {
        for (int column = first_bright; column < columns; column += 2) {
          pixels[area(row, columns) + static_cast<std::size_t>(column)] = 255;
        }
      }
      for (const model::Mode mode : kModes) {
        for (const int threshold : {0, 1, 254}) {
          expect_right(view_of(pixels, spec::kRowLimit, columns), mode, threshold);
        }
      }
    }
  }
}

TEST_F(FastMoments, StridesAndAlignments) {
  constexpr int kRows = 25;
  Random random(1);
  const std::vector<std::uint8_t> pixels = random.bytes(64 + area(kRows, 700));
  for (int offset = 0; offset < 64; ++offset) {
    for (const int columns : {1, 4, 64, 130, 516}) {
      for (const int stride : {columns, columns + 1, 640, 700}) {
        for (const model::Mode mode : kModes) {
          expect_right({pixels.data() + offset, kRows, columns, stride}, mode, 128);
        }
      }
      expect_right({pixels.data() + offset + (kRows - 1) * 700, kRows, columns, -700}, model::Mode::grey, 60);
      expect_right({pixels.data() + offset, kRows, columns, 0}, model::Mode::grey_over, 60);
    }
  }
}

// The image ends where its memory ends, so that the address sanitizer sees any access beyond.
TEST_F(FastMoments, ReadsNothingBeyondTheImage) {
  for (const int columns : kColumnEdges) {
    const std::vector<std::uint8_t> pixels(area(9, 2000) + static_cast<std::size_t>(columns), 77);
    for (const model::Mode mode : kModes) {
      expect_right({pixels.data(), 10, columns, 2000}, mode, 76);
    }
  }
}

#if defined(__linux__)
// The image fills memory between two pages that cannot be read: a read beyond it ends the program, a prefetch does not.
TEST_F(FastMoments, BetweenPagesThatCannotBeRead) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t bytes = 16 * page;
  void* const memory = mmap(nullptr, bytes + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  std::uint8_t* const first = static_cast<std::uint8_t*>(memory) + page;
  ASSERT_EQ(mprotect(first, bytes, PROT_READ | PROT_WRITE), 0);
  const std::vector<std::uint8_t> pixels = Random(1).bytes(bytes);
  std::copy(pixels.begin(), pixels.end(), first);
  for (const int columns : {1, 16, 21, 64, 100, 512, 700, 2048}) {
    const int rows = static_cast<int>(bytes) / columns > 60 ? 60 : static_cast<int>(bytes) / columns;
    const std::size_t image = area(rows, columns);
    for (const model::Mode mode : kModes) {
      expect_right({first, rows, columns, columns}, mode, 128);
      expect_right({first + bytes - image, rows, columns, columns}, mode, 128);
      expect_right({first + (rows - 1) * columns, rows, columns, -columns}, mode, 128);  // upside down
    }
  }
  munmap(memory, bytes + 2 * page);
}
#endif

TEST_F(FastMoments, RandomImages) {
  for (const std::uint64_t seed : seeds(300)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(1, random.chance(10) ? spec::kRowLimit : 120);
    const int columns = random.between(1, random.chance(10) ? spec::kMaxColumns : 600);
    const int stride = columns + random.between(0, 40);
    std::vector<std::uint8_t> pixels = random.bytes(area(rows, stride));
    if (random.chance(50)) {  // bright images make large sums
      for (std::uint8_t& pixel : pixels) {
        pixel |= 0xC0;
      }
    }
    for (const model::Mode mode : kModes) {
      expect_right({pixels.data(), rows, columns, stride}, mode, random.chance(50) ? random.between(0, 255) : 0);
      if (HasFatalFailure()) {
        return;
      }
    }
  }
}

TEST_F(FastMoments, RefusesWhatIsOutOfRange) {
  expect_refusals_of_moments(
      [](const model::ImageView& image, model::Mode mode, int threshold, const model::MomentsView& out) {
        light_section::fast_column_moments(image, mode, threshold, out);
      });
}

// Pixels of 8 to 12 bits, one in each word of 16.
class FastWideMoments : public FastMoments {
 protected:
  static void expect_right(const model::WideImageView& image, int bits, model::Mode mode, int threshold) {
    constexpr std::size_t kGuard = 64;
    model::Moments right, found;
    right.resize(image.columns);
    model::column_moments(image, bits, mode, threshold, right.view());
    for (auto* values : {&found.m0, &found.m1, &found.n}) {
      values->assign(right.m0.size() + kGuard, kUntouched);
    }
    light_section::fast_column_moments(image, bits, mode, threshold, found.view());
    for (auto* values : {&found.m0, &found.m1, &found.n}) {
      EXPECT_TRUE(std::all_of(values->end() - kGuard, values->end(), [](std::uint32_t v) { return v == kUntouched; }));
    }
    found.resize(image.columns);
    ASSERT_TRUE(found == right) << "rows " << image.rows << ", columns " << image.columns << ", stride " << image.stride
                                << ", bits " << bits << ", mode " << static_cast<int>(mode) << ", threshold "
                                << threshold;
  }

  static std::vector<std::uint16_t> random_pixels(Random& random, std::size_t count, int bits) {
    std::vector<std::uint16_t> pixels(count);
    for (std::uint16_t& pixel : pixels) {
      pixel = static_cast<std::uint16_t>(random.between(0, (1 << bits) - 1));
    }
    return pixels;
  }
};

TEST_F(FastWideMoments, EverySizeThatEndsWhereItsMemoryEnds) {
  Random random(1);
  for (const int rows : {1, 2, 63, 64, 65, 96, 127, 128, 129, 200}) {
    for (const int columns : kColumnEdges) {
      for (const int bits : {8, 10, 12}) {
        const std::vector<std::uint16_t> pixels = random_pixels(random, area(rows, columns), bits);
        for (const model::Mode mode : kModes) {
          expect_right({pixels.data(), rows, columns, columns}, bits, mode, random.between(0, (1 << bits) - 1));
          if (HasFatalFailure()) {
            return;
          }
        }
      }
    }
  }
}

// The largest sums of all, and the largest beside the least: the grey modes add two columns as one word.
TEST_F(FastWideMoments, LargestSums) {
  constexpr int kColumns = 131;
  for (const int bits : {10, 12}) {
    const int rows = model::row_limit(bits), white = (1 << bits) - 1;
    for (const int step : {1, 2}) {
      std::vector<std::uint16_t> pixels(area(rows, kColumns), 0);
      for (std::size_t i = 0; i < pixels.size(); i += static_cast<std::size_t>(step)) {
        pixels[i] = static_cast<std::uint16_t>(white);
      }
      for (const model::Mode mode : kModes) {
        for (const int threshold : {0, 1, white - 1, white}) {
          expect_right({pixels.data(), rows, kColumns, kColumns}, bits, mode, threshold);
        }
      }
    }
  }
}

TEST_F(FastWideMoments, RandomImages) {
  for (const std::uint64_t seed : seeds(100)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int bits = random.between(8, model::kMaxPixelBits);
    const int rows = random.between(1, random.chance(10) ? model::row_limit(bits) : 120);
    const int columns = random.between(1, random.chance(10) ? spec::kMaxColumns : 600);
    const int stride = columns + random.between(0, 40);
    const std::vector<std::uint16_t> pixels = random_pixels(random, area(rows, stride), bits);
    const std::uint16_t* const last = pixels.data() + static_cast<std::ptrdiff_t>(rows - 1) * stride;
    for (const model::Mode mode : kModes) {
      const int threshold = random.between(0, (1 << bits) - 1);
      expect_right({pixels.data(), rows, columns, stride}, bits, mode, threshold);
      expect_right({last, rows, columns, -stride}, bits, mode, threshold);
      if (HasFatalFailure()) {
        return;
      }
    }
  }
}

TEST_F(FastWideMoments, RefusesWhatIsOutOfRange) {
  const std::vector<std::uint16_t> words(64, 1);
  for (const int bits : {8, 12}) {
    expect_refusals_of_moments(
        [&](const model::ImageView& image, model::Mode mode, int threshold, const model::MomentsView& out) {
          const std::uint16_t* const pixels = image.pixels != nullptr ? words.data() : nullptr;
          const int level = threshold == 256 ? 1 << bits : threshold;
          light_section::fast_column_moments({pixels, image.rows, image.columns, image.stride}, bits, mode, level, out);
        });
  }
  model::Moments moments;
  moments.resize(8);
  for (const int bits : {7, 13}) {
    EXPECT_THROW(
        light_section::fast_column_moments({words.data(), 8, 8, 8}, bits, model::Mode::grey, 1, moments.view()),
        std::invalid_argument);
  }
}

class FastRuns : public FastMoments {};

template <typename Pixel>
void expect_right_runs(const model::PixelView<Pixel>& image, const model::Measure& measure) {
  model::Runs right;
  model::Runs found;
  right.resize(measure.select, image.columns);
  found.resize(measure.select, image.columns);
  model::measure_columns(image, measure, right.view());
  light_section::fast_measure_columns(image, measure, found.view());
  ASSERT_TRUE(found == right) << image.columns << " x " << image.rows << ", mode " << static_cast<int>(measure.mode)
                              << ", threshold " << measure.threshold << ", gap " << measure.gap << ", rows "
                              << measure.window.first << ".." << measure.window.last;
}

TEST_F(FastRuns, RandomImages) {
  for (const std::uint64_t seed : seeds(3000)) {
    SCOPED_TRACE(how_to_repeat(seed));
    RandomRuns random(seed);
    expect_right_runs(random.image, random.measure);
    random.measure.select = model::Select::all;
    expect_right_runs(random.image, random.measure);
    if (HasFatalFailure()) {
      return;
    }
  }
}

// Pixels of 9 to 12 bits: those of 8 with more bits below them.
TEST_F(FastRuns, RandomImagesOfMoreBits) {
  for (const std::uint64_t seed : seeds(1000)) {
    SCOPED_TRACE(how_to_repeat(seed));
    RandomRuns random(seed);
    Random more(seed);
    const int below = more.between(1, model::kMaxPixelBits - spec::kPixelBits);
    std::vector<std::uint16_t> wide;
    const model::ImageView& image = random.image;
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.columns; ++column) {
        wide.push_back(static_cast<std::uint16_t>(image.pixels[row * image.stride + column] << below |
                                                  more.between(0, (1 << below) - 1)));
      }
    }
    random.measure.bits = spec::kPixelBits + below;
    random.measure.threshold = random.measure.threshold << below | more.between(0, (1 << below) - 1);
    expect_right_runs(model::WideImageView{wide.data(), image.rows, image.columns, image.columns}, random.measure);
    if (HasFatalFailure()) {
      return;
    }
  }
}

// Images of lines, of which only a few columns have something else as well: the case for which it is fast.
TEST_F(FastRuns, LinesWithAFewHotPixels) {
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
    model::Measure measure{.mode = static_cast<model::Mode>(random.between(0, 2)),
                           .threshold = random.between(0, 100),
                           .select = model::Select::strongest,
                           .gap = random.between(0, model::kMaxGap)};
    expect_right_runs(model::ImageView{pixels.data(), rows, columns, columns}, measure);
    measure.window = {random.between(0, rows), random.between(0, rows)};
    expect_right_runs(model::ImageView{pixels.data(), rows, columns, columns}, measure);
    if (HasFatalFailure()) {
      return;
    }
  }
}

// 512 runs in a column are more than 8 bits count.
TEST_F(FastRuns, ManyRuns) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(spec::kRowLimit) * 300, 0);
  for (std::size_t row = 0; row < spec::kRowLimit; row += 2) {
    for (std::size_t column = 0; column < 300; ++column) {
      pixels[row * 300 + column] = static_cast<std::uint8_t>(100 + column % 7);
    }
  }
  for (int gap = 0; gap <= model::kMaxGap; ++gap) {
    expect_right_runs(
        model::ImageView{pixels.data(), spec::kRowLimit, 300, 300},
        {.mode = model::Mode::grey_over, .threshold = 50, .select = model::Select::strongest, .gap = gap});
  }
}

TEST_F(FastRuns, RefusesWhatTheModelRefuses) {
  std::vector<std::uint8_t> small(8);
  expect_refusals_of_moments([&](const model::ImageView& image, model::Mode mode, int threshold,
                                 const model::MomentsView& out) {
    light_section::fast_column_runs(image, {.mode = mode, .threshold = threshold, .select = model::Select::strongest},
                                    {out, small.data(), small.data()});
  });
}

}  // namespace
}  // namespace selfproj::test
