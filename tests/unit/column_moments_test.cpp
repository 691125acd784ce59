// Compares the definition of the column moments with values computed by hand or in closed form. Integer sums are exact,
// so no test here has a tolerance.
#include "selfproj/model/column_moments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/support/moments_refusals.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr std::array kModes = {model::Mode::binary, model::Mode::grey, model::Mode::grey_over};

model::Moments moments_of(const model::ImageView& image, model::Mode mode, int threshold) {
  model::Moments moments;
  moments.resize(image.columns);
  model::column_moments(image, mode, threshold, moments.view());
  return moments;
}

model::ImageView view_of(const std::vector<std::uint8_t>& pixels, int rows, int columns) {
  return {pixels.data(), rows, columns, columns};
}

std::size_t area(int rows, int columns) { return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns); }

// The weight of a lit pixel.
std::uint32_t weight_of(model::Mode mode, int value, int threshold) {
  return static_cast<std::uint32_t>(mode == model::Mode::binary ? 1
                                    : mode == model::Mode::grey ? value
                                                                : value - threshold);
}

TEST(ColumnMoments, ByHand) {
  const std::vector<std::uint8_t> pixels = {10, 0, 5,  //
                                            11, 5, 5,  //
                                            12, 6, 255};
  using Words = std::vector<std::uint32_t>;
  const model::ImageView image = view_of(pixels, 3, 3);
  EXPECT_EQ(moments_of(image, model::Mode::binary, 5),
            (model::Moments{.m0 = {3, 1, 1}, .m1 = {6, 3, 3}, .n = {3, 1, 1}}));
  EXPECT_EQ(moments_of(image, model::Mode::grey, 5),
            (model::Moments{.m0 = {33, 6, 255}, .m1 = {10 + 22 + 36, 18, 765}, .n = {3, 1, 1}}));
  EXPECT_EQ(moments_of(image, model::Mode::grey_over, 5),
            (model::Moments{.m0 = {18, 1, 250}, .m1 = {5 + 12 + 21, 3, 750}, .n = {3, 1, 1}}));
  EXPECT_EQ(moments_of(image, model::Mode::grey, 255).n, Words(3, 0));
}

TEST(ColumnMoments, EqualImages) {
  for (const int rows : {1, 2, 7, 96, 256}) {
    for (const int columns : {1, 3, 4, 33, 512, 1028}) {
      for (const int value : {0, 100, 101, 255}) {
        const std::vector<std::uint8_t> pixels(area(rows, columns), static_cast<std::uint8_t>(value));
        for (const model::Mode mode : kModes) {
          const model::Moments moments = moments_of(view_of(pixels, rows, columns), mode, 100);
          const auto n = static_cast<std::uint32_t>(value > 100 ? rows : 0);
          const std::uint32_t weight = n > 0 ? weight_of(mode, value, 100) : 0;
          const std::uint32_t m1 = n * (n + 1) / 2 * weight;
          ASSERT_EQ(moments.n, std::vector<std::uint32_t>(moments.n.size(), n)) << rows << " x " << columns;
          ASSERT_EQ(moments.m0, std::vector<std::uint32_t>(moments.n.size(), n * weight)) << rows << " x " << columns;
          ASSERT_EQ(moments.m1, std::vector<std::uint32_t>(moments.n.size(), m1)) << rows << " x " << columns;
        }
      }
    }
  }
}

// A single lit pixel in every place of an image of many rows, and of one of many columns.
TEST(ColumnMoments, OnePixelEverywhere) {
  constexpr int kThreshold = 17;
  constexpr std::uint8_t kValue = 200;
  for (const auto& [rows, columns] : {std::pair{47, 132}, std::pair{2, 1100}}) {
    std::vector<std::uint8_t> pixels(area(rows, columns), kThreshold);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        std::uint8_t& pixel = pixels[area(row, columns) + static_cast<std::size_t>(column)];
        pixel = kValue;
        const model::Mode mode = kModes[static_cast<std::size_t>(row + column) % kModes.size()];
        const model::Moments moments = moments_of(view_of(pixels, rows, columns), mode, kThreshold);
        pixel = kThreshold;

        model::Moments right;
        right.resize(columns);
        const auto at = static_cast<std::size_t>(column);
        right.n[at] = 1;
        right.m0[at] = weight_of(mode, kValue, kThreshold);
        right.m1[at] = right.m0[at] * static_cast<std::uint32_t>(row + 1);
        ASSERT_EQ(moments, right) << "row " << row << ", column " << column;
      }
    }
  }
}

// Every pixel value (one a column) under every threshold.
TEST(ColumnMoments, EveryValueAndThreshold) {
  constexpr int kColumns = 256;
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < kColumns; ++i) {
    pixels.push_back(static_cast<std::uint8_t>(i));
  }
  for (int threshold = 0; threshold <= 255; ++threshold) {
    for (const model::Mode mode : kModes) {
      const model::Moments moments = moments_of(view_of(pixels, 1, kColumns), mode, threshold);
      for (int value = 0; value < kColumns; ++value) {
        const auto at = static_cast<std::size_t>(value);
        ASSERT_EQ(moments.n[at], value > threshold ? 1U : 0U);
        ASSERT_EQ(moments.m0[at], value > threshold ? weight_of(mode, value, threshold) : 0U);
        ASSERT_EQ(moments.m1[at], moments.m0[at]);
      }
    }
  }
}

TEST(ColumnMoments, FirstAndLastRow) {
  for (const int rows : {1, 2, 22, 23, 96, spec::kMaxRows}) {
    constexpr int kColumns = 68;
    for (const int row : {0, rows - 1}) {
      std::vector<std::uint8_t> pixels(area(rows, kColumns), 0);
      std::fill_n(pixels.begin() + row * kColumns, kColumns, 255);
      const model::Moments moments = moments_of(view_of(pixels, rows, kColumns), model::Mode::binary, 254);
      EXPECT_EQ(moments.m0, std::vector<std::uint32_t>(kColumns, 1));
      EXPECT_EQ(moments.m1, std::vector<std::uint32_t>(kColumns, static_cast<std::uint32_t>(row + 1)));
    }
  }
}

// The largest and brightest image gives the largest sums, for which the number formats are designed.
TEST(ColumnMoments, LargestSums) {
  const std::vector<std::uint8_t> pixels(area(spec::kMaxRows, spec::kMaxColumns), 255);
  const model::ImageView image = view_of(pixels, spec::kMaxRows, spec::kMaxColumns);
  const auto all = [](std::uint64_t value) {
    return std::vector<std::uint32_t>(spec::kMaxColumns, static_cast<std::uint32_t>(value));
  };
  const model::Moments binary = moments_of(image, model::Mode::binary, 0);
  EXPECT_EQ(binary.m0, all(spec::kBinaryM0Max));
  EXPECT_EQ(binary.m1, all(spec::kBinaryM1Max));
  EXPECT_EQ(binary.n, all(spec::kBinaryM0Max));
  const model::Moments grey = moments_of(image, model::Mode::grey, 254);
  EXPECT_EQ(grey.m0, all(spec::kGreyM0Max));
  EXPECT_EQ(grey.m1, all(spec::kGreyM1Max));
  EXPECT_EQ(grey.n, all(spec::kGreyNMax));
  EXPECT_EQ(moments_of(image, model::Mode::grey_over, 0), grey);
  const model::Moments over = moments_of(image, model::Mode::grey_over, 254);
  EXPECT_EQ(over, binary);
  for (const model::Mode mode : kModes) {
    const model::Moments none = moments_of(image, mode, 255);
    EXPECT_EQ(none.m1, all(0));
    EXPECT_EQ(none.n, all(0));
  }
}

// A view into a larger image, upside down or not, has the moments of its copy; nothing beyond its columns is written.
TEST(ColumnMoments, Strides) {
  constexpr int kRows = 25;
  constexpr int kStride = 70;
  constexpr int kGuard = 4;
  constexpr std::uint32_t kUntouched = 0xDEADBEEF;
  Random random(1);
  const std::vector<std::uint8_t> pixels = random.bytes(area(kRows, kStride));
  for (const int columns : {1, 4, 63, 70}) {
    for (const bool upside_down : {false, true}) {
      const int first = upside_down ? kRows - 1 : 0;
      const model::ImageView view = {pixels.data() + area(first, kStride), kRows, columns,
                                     upside_down ? -kStride : kStride};
      std::vector<std::uint8_t> copy;
      for (int row = 0; row < kRows; ++row) {
        const std::uint8_t* line = view.pixels + row * view.stride;
        copy.insert(copy.end(), line, line + columns);
      }
      for (const model::Mode mode : kModes) {
        model::Moments moments;
        moments.m0 = moments.m1 = moments.n =
            std::vector<std::uint32_t>(static_cast<std::size_t>(columns + kGuard), kUntouched);
        model::column_moments(view, mode, 100, moments.view());
        for (const auto* values : {&moments.m0, &moments.m1, &moments.n}) {
          EXPECT_EQ(std::count(values->end() - kGuard, values->end(), kUntouched), kGuard);
        }
        moments.resize(columns);
        EXPECT_EQ(moments, moments_of(view_of(copy, kRows, columns), mode, 100));
      }
    }
  }
}

// An image is the sum of its upper and its lower part. In the lower part all row numbers are greater.
TEST(ColumnMoments, PartsOfRandomImages) {
  for (const std::uint64_t seed : seeds(300)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(2, random.chance(10) ? spec::kMaxRows : 120);
    const int columns = random.between(1, 100);
    const int above = random.between(1, rows - 1);
    const int threshold = random.chance(50) ? random.between(0, 255) : 0;
    const std::vector<std::uint8_t> pixels = random.bytes(area(rows, columns));
    for (const model::Mode mode : kModes) {
      const model::Moments all = moments_of(view_of(pixels, rows, columns), mode, threshold);
      const model::Moments upper = moments_of(view_of(pixels, above, columns), mode, threshold);
      const model::Moments lower =
          moments_of({pixels.data() + area(above, columns), rows - above, columns, columns}, mode, threshold);
      for (std::size_t i = 0; i < all.n.size(); ++i) {
        ASSERT_EQ(all.n[i], upper.n[i] + lower.n[i]);
        ASSERT_EQ(all.m0[i], upper.m0[i] + lower.m0[i]);
        ASSERT_EQ(all.m1[i], upper.m1[i] + lower.m1[i] + static_cast<std::uint32_t>(above) * lower.m0[i]);
      }
    }
  }
}

// Worked out by hand: rows 1 to 3 of 12 bits, threshold 1000.
TEST(ColumnMoments, PixelsOfTwelveBits) {
  const std::vector<std::uint16_t> pixels = {1000, 4095,   //
                                             1001, 4095,   //
                                             3000, 1000};  //
  const auto moments_of = [&](model::Mode mode, const model::RowWindow& window = {}) {
    model::Moments moments;
    moments.resize(2);
    model::column_moments(model::WideImageView{pixels.data(), 3, 2, 2}, 12, mode, 1000, moments.view(), window);
    return moments;
  };
  EXPECT_EQ(moments_of(model::Mode::binary), (model::Moments{{2, 2}, {5, 3}, {2, 2}}));
  EXPECT_EQ(moments_of(model::Mode::grey), (model::Moments{{4001, 8190}, {11002, 12285}, {2, 2}}));
  EXPECT_EQ(moments_of(model::Mode::grey_over), (model::Moments{{2001, 6190}, {6002, 9285}, {2, 2}}));
  EXPECT_EQ(moments_of(model::Mode::grey, {2, 2}), (model::Moments{{1001, 4095}, {2002, 8190}, {1, 1}}));
}

TEST(ColumnMoments, RefusesWhatIsOutOfRange) {
  expect_refusals_of_moments([](const model::ImageView& image, model::Mode mode, int threshold,
                                const model::MomentsView& out) { model::column_moments(image, mode, threshold, out); });
}

}  // namespace
}  // namespace selfproj::test
