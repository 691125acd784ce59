// Compares the fast decoder and median with the models bit for bit. Integers are exact, so no test has a tolerance.

#include "selfproj/structured_light/fast_decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/median3x3.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// A frame in which neighbouring values of a pair are often close to each other, so that every outcome of the threshold
// is frequent.
std::vector<std::uint8_t> random_frame(Random& random, std::size_t size, int spread) {
  std::vector<std::uint8_t> pixels(size);
  const int base = random.between(0, 255);
  for (std::uint8_t& pixel : pixels) {
    pixel = static_cast<std::uint8_t>(std::clamp(base + random.between(-spread, spread), 0, 255));
  }
  return pixels;
}

TEST(FastGrayDecoder, EqualsTheModelOverRandomSequences) {
  for (const std::uint64_t seed : seeds(150)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    model::GraySettings settings;
    settings.rows = random.between(1, 24);
    settings.columns = random.between(1, 300);
    settings.bits = random.between(1, 12);
    settings.threshold = random.chance(10) ? random.between(0, 255) : random.between(0, 20);
    const int stride = settings.columns + (random.chance(50) ? 0 : random.between(1, 70));
    const std::size_t size = static_cast<std::size_t>(stride) * static_cast<std::size_t>(settings.rows);
    model::GrayDecoder model(settings);
    structured_light::FastGrayDecoder fast(settings);
    structured_light::FastMedian median(settings.columns + random.between(0, 5));
    const std::size_t words = static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns);
    std::vector<std::uint16_t> expected(words), found(words), expected_median(words), found_median(words);
    std::vector<std::uint8_t> previous, current;
    int pattern = 0;
    const int spread = random.between(1, 120);
    for (int frame = 0; frame < 6 * settings.bits + 8; ++frame) {
      previous = std::move(current);
      current = random_frame(random, size, spread);
      const model::ImageView view{current.data(), settings.rows, settings.columns, stride};
      const bool good = !random.chance(2);
      if (random.chance(2)) {
        pattern = random.between(0, 2 * settings.bits);  // a frame is missing, or its index is wrong
      }
      if (random.chance(1)) {
        model.restart();
        fast.restart();
      }
      const bool due = model.add_frame(view, pattern, good, expected.data());
      ASSERT_EQ(fast.add_frame(view, pattern, good), due) << "frame " << frame;
      pattern = (pattern + 1) % (2 * settings.bits);
      if (due) {
        structured_light::code_words(fast.codes(), found.data());
        ASSERT_EQ(found, expected) << "frame " << frame;
        model::median3x3(expected.data(), settings.rows, settings.columns, expected_median.data());
        median.filter(fast.codes(), found_median.data());
        ASSERT_EQ(found_median, expected_median) << "frame " << frame;
      }
    }
  }
}

// Every number of measurable neighbours at every position of the border, with codes up to the largest.
TEST(FastMedian, EqualsTheModelOverRandomCodes) {
  for (const std::uint64_t seed : seeds(400)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(1, 9);
    const int columns = random.chance(50) ? random.between(1, 5) : random.between(1, 200);
    const int bits = random.between(1, 12);
    const auto count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
    std::vector<std::uint8_t> codes8(count), ambiguous8(count);
    std::vector<std::uint16_t> codes16(count), ambiguous16(count), words(count), expected(count), found(count);
    const int measurable_percent = random.between(0, 100);
    const int top = (1 << bits) - 1;
    for (std::size_t i = 0; i < count; ++i) {
      const int code = random.chance(20) ? top : random.between(0, top);
      const int flags = random.chance(measurable_percent) || bits < 2 ? (random.chance(50) ? 0 : 1) : 3;
      codes8[i] = static_cast<std::uint8_t>(code);
      codes16[i] = static_cast<std::uint16_t>(code);
      ambiguous8[i] = static_cast<std::uint8_t>(flags);
      ambiguous16[i] = static_cast<std::uint16_t>(flags);
    }
    structured_light::CodeImageView image{rows, columns, bits, nullptr, nullptr, nullptr, nullptr};
    if (bits <= 8) {
      image.codes8 = codes8.data();
      image.ambiguous8 = ambiguous8.data();
    } else {
      image.codes16 = codes16.data();
      image.ambiguous16 = ambiguous16.data();
    }
    structured_light::code_words(image, words.data());
    model::median3x3(words.data(), rows, columns, expected.data());
    structured_light::FastMedian median(columns);
    median.filter(image, found.data());
    ASSERT_EQ(found, expected) << rows << " x " << columns << ", " << bits << " bits";
  }
}

TEST(FastGrayDecoder, RefusesWhatIsOutOfRange) {
  EXPECT_THROW(structured_light::FastGrayDecoder({0, 4, 8, 5}), std::invalid_argument);
  EXPECT_THROW(structured_light::FastGrayDecoder({4, 0, 8, 5}), std::invalid_argument);
  EXPECT_THROW(structured_light::FastGrayDecoder({4, 4, 0, 5}), std::invalid_argument);
  EXPECT_THROW(structured_light::FastGrayDecoder({4, 4, 13, 5}), std::invalid_argument);
  EXPECT_THROW(structured_light::FastGrayDecoder({4, 4, 8, 256}), std::invalid_argument);
  EXPECT_THROW(structured_light::FastGrayDecoder({4, 4, 8, -1}), std::invalid_argument);
  EXPECT_THROW(structured_light::FastMedian(0), std::invalid_argument);
  structured_light::FastGrayDecoder decoder({4, 4, 8, 5});
  const std::vector<std::uint8_t> pixels(16);
  EXPECT_THROW(decoder.add_frame({pixels.data(), 2, 8, 8}, 0, true), std::invalid_argument);
  EXPECT_THROW(decoder.add_frame({nullptr, 4, 4, 4}, 0, true), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
