// Images of Gray codes in right and wrong orders, of surfaces, widths of stripes and noise drawn at random.

#include "host/structured_light/sequence_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kRows = 120;
constexpr int kColumns = 200;

// The images of a leaning, bent surface under `bits` pairs, of which the view holds nearly all codes.
std::vector<images::Image> views(Random& random, int bits) {
  const bool along_rows = random.between(0, 1) == 1;
  const double lean = 0.002 * random.between(-100, 100);
  const double bend = 0.0005 * random.between(-100, 100);
  const int contrast = random.between(60, 200);
  const int noise = random.between(0, 3);
  const double codes = std::ldexp(1.0, bits);
  std::vector<images::Image> images;
  for (int image = 0; image < 2 * bits; ++image) {
    images::Image& view = images.emplace_back(images::Image{kRows, kColumns, {}});
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kColumns; ++c) {
        const double along = along_rows ? static_cast<double>(r) / kRows : static_cast<double>(c) / kColumns;
        const double across = along_rows ? static_cast<double>(c) / kColumns : static_cast<double>(r) / kRows;
        const double place = 0.05 + 0.85 * along + 0.1 * lean * across + bend * std::sin(9 * across);
        const auto code = static_cast<unsigned>(std::clamp(place * codes, 0.0, codes - 1));
        const unsigned gray = code ^ (code >> 1U);
        const bool light = (((gray >> static_cast<unsigned>(bits - 1 - image / 2)) & 1U) != 0) != (image % 2 != 0);
        view.pixels.push_back(
            static_cast<std::uint8_t>(8 + noise + (light ? contrast : 0) + random.between(-noise, noise)));
      }
    }
  }
  return images;
}

std::string contradiction(const std::vector<images::Image>& images) {
  structured_light::SequenceCheck check(kRows, kColumns, static_cast<int>(images.size() / 2));
  std::vector<std::string> names;
  for (std::size_t i = 0; i < images.size(); ++i) {
    check.add(static_cast<int>(i), images[i].view());
    names.push_back("image " + std::to_string(i));
  }
  return structured_light::contradiction_of(check, names);
}

void exchange(std::vector<images::Image>& images, std::size_t plane) {
  std::swap(images[2 * plane], images[2 * plane + 1]);
}

TEST(SequenceCheck, RightOrdersPassAndWrongOnesAreNoticed) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const auto bits = static_cast<std::size_t>(random.between(4, 5));
    const std::vector<images::Image> good = views(random, static_cast<int>(bits));
    EXPECT_EQ(contradiction(good), "");

    std::vector<images::Image> wrong(good.rbegin(), good.rend());
    EXPECT_NE(contradiction(wrong), "") << "reversed";
    for (std::size_t plane = 0; plane < bits; ++plane) {
      exchange(wrong, plane);
    }
    EXPECT_NE(contradiction(wrong), "") << "least significant bit first";

    wrong = good;
    for (std::size_t plane = 0; plane < bits; ++plane) {
      exchange(wrong, plane);
    }
    EXPECT_NE(contradiction(wrong), "") << "positive and negative exchanged";
    wrong = good;
    exchange(wrong, static_cast<std::size_t>(random.between(1, static_cast<int>(bits) - 1)));
    EXPECT_NE(contradiction(wrong), "") << "one pair exchanged";

    wrong = good;
    const auto late = static_cast<std::size_t>(random.between(1, static_cast<int>(good.size()) - 1));
    wrong[late] = good[late - 1];
    const std::string text = contradiction(wrong);
    EXPECT_NE(text.find("image " + std::to_string(late)), std::string::npos)
        << "image " << late << " is late: " << text;

    std::vector<std::size_t> lexical(good.size());
    for (std::size_t i = 0; i < lexical.size(); ++i) {
      lexical[i] = i;
    }
    if (good.size() > 9) {
      std::sort(lexical.begin(), lexical.end(),
                [](std::size_t a, std::size_t b) { return std::to_string(a + 1) < std::to_string(b + 1); });
      for (std::size_t i = 0; i < lexical.size(); ++i) {
        wrong[i] = good[lexical[i]];
      }
      EXPECT_NE(contradiction(wrong), "") << "lexical";
    }
  }
}

// An image of another scan: in a tenth of the view it does not fit, and where nothing is lit in the others it shows
// something bright, so that its pair has the most contrast there.
TEST(SequenceCheck, AnImageOfAnotherScanIsNamed) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int bits = random.between(4, 10);
    std::vector<images::Image> images = views(random, bits);
    const auto foreign = static_cast<std::size_t>(random.between(0, 7));
    for (std::size_t i = 0; i < images[foreign].pixels.size(); ++i) {
      const std::size_t column = i % kColumns;
      if (column < kColumns / 10) {
        images[foreign].pixels[i] = images[foreign ^ 1U].pixels[i];
      } else if (column >= kColumns * 3 / 4) {
        for (images::Image& image : images) {
          image.pixels[i] = 8;
        }
        images[foreign].pixels[i] = 150;
      }
    }
    const std::string text = contradiction(images);
    EXPECT_TRUE(text.starts_with("image " + std::to_string(foreign & ~std::size_t{1}) + " and "))
        << foreign << ": " << text;
  }
}

// A camera of few pixels sees the finest stripes as if they were wide.
TEST(SequenceCheck, StripesNarrowerThanPixelsAreInOrder) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int bits = random.between(6, 10);
    std::vector<images::Image> images = views(random, bits);
    EXPECT_EQ(contradiction(images), "") << bits << " bits";
    std::reverse(images.begin(), images.end());
    EXPECT_NE(contradiction(images), "") << bits << " bits, reversed";
  }
}

TEST(SequenceCheck, SaysNothingOfWhatIsNotLit) {
  const std::vector<images::Image> dark(8,
                                        images::Image{kRows, kColumns, std::vector<std::uint8_t>(kRows * kColumns, 7)});
  EXPECT_EQ(contradiction(dark), "");
}

TEST(SequenceCheck, WhiteIsBrighterThanBlackEverywhere) {
  Random random(1);
  const std::vector<images::Image> codes = views(random, 4);
  const images::Image black{kRows, kColumns, std::vector<std::uint8_t>(kRows * kColumns, 7)};
  const images::Image white{kRows, kColumns, std::vector<std::uint8_t>(kRows * kColumns, 90)};
  EXPECT_TRUE(structured_light::SequenceCheck::is_white_and_black(white.view(), black.view()));
  EXPECT_FALSE(structured_light::SequenceCheck::is_white_and_black(black.view(), white.view()));
  EXPECT_FALSE(structured_light::SequenceCheck::is_white_and_black(codes[6].view(), codes[7].view()));
}

}  // namespace
}  // namespace selfproj::test
