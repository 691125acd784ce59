// Tests the sequence of Gray-code patterns: the code of every pixel, the order, and the patterns of real captures.

#include "selfproj/structured_light/gray_sequence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(GraySequence, CountsBits) {
  for (const auto& [side, bits] :
       {std::pair{1, 1}, {2, 1}, {3, 2}, {4, 2}, {5, 3}, {768, 10}, {1024, 10}, {1025, 11}}) {
    const structured_light::GraySequence columns(side, 1);
    EXPECT_EQ(columns.column_bits(), bits) << side;
    EXPECT_EQ(columns.row_bits(), 1);
    EXPECT_EQ(columns.count(), 2 * bits + 4);
    EXPECT_EQ(structured_light::GraySequence(1, side).row_bits(), bits) << side;
  }
  EXPECT_THROW(structured_light::GraySequence(0, 4), std::invalid_argument);
  EXPECT_THROW(structured_light::GraySequence(4, structured_light::GraySequence::kMaxSide + 1), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(structured_light::GraySequence(4, 4).image(10)), std::out_of_range);
  EXPECT_THROW(static_cast<void>(structured_light::GraySequence(4, 4).image(-1)), std::out_of_range);
}

// Decoding the projected images themselves gives the column and the row of each pixel.
TEST(GraySequence, DecodesToColumnAndRow) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const structured_light::GraySequence sequence(random.between(1, 200), random.between(1, 200));
    const std::size_t pixels = static_cast<std::size_t>(sequence.rows()) * static_cast<std::size_t>(sequence.columns());
    for (const bool rows : {false, true}) {
      const int bits = rows ? sequence.row_bits() : sequence.column_bits();
      const int first = rows ? sequence.first_of_rows() : 0;
      structured_light::FastGrayDecoder decoder({sequence.rows(), sequence.columns(), bits, 5});
      std::vector<std::vector<std::uint8_t>> images;
      for (int i = 0; i < 2 * bits; ++i) {
        images.push_back(sequence.image(first + i));
      }
      for (int i = 0; i < 2 * bits; ++i) {
        const auto& image = images[static_cast<std::size_t>(i)];
        decoder.add_frame({image.data(), sequence.rows(), sequence.columns(), sequence.columns()}, i);
      }
      std::vector<std::uint16_t> words(pixels);
      structured_light::unambiguous_code_words(decoder.codes(), words.data());
      std::size_t i = 0;
      for (int r = 0; r < sequence.rows(); ++r) {
        for (int c = 0; c < sequence.columns(); ++c, ++i) {
          ASSERT_EQ(words[i], 0x8000 | (rows ? r : c)) << r << ", " << c;
        }
      }
    }
    const auto all = [](const std::vector<std::uint8_t>& image, int value) {
      return std::all_of(image.begin(), image.end(), [&](std::uint8_t pixel) { return pixel == value; });
    };
    EXPECT_TRUE(all(sequence.image(sequence.white()), 255));
    EXPECT_TRUE(all(sequence.image(sequence.black()), 0));
    EXPECT_EQ(sequence.black() + 1, sequence.count());
  }
}

// The patterns of captures made by others.
TEST(GraySequence, IsThatOfTheRealCaptures) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(SELFPROJ_SOURCE_DIR) / "../shared/data/gray-kamino-pose0/graycode_pattern";
  if (!fs::exists(folder)) {
    GTEST_SKIP() << "no " << folder;
  }
  const structured_light::GraySequence sequence(1024, 768);
  const std::vector<std::string> files = images::files_of_folder(folder.string());
  ASSERT_EQ(files.size(), static_cast<std::size_t>(sequence.count()));
  for (std::size_t i = 0; i < files.size(); ++i) {
    EXPECT_EQ(images::read_image(files[i], images::Channel::grey).pixels, sequence.image(static_cast<int>(i)))
        << files[i];
  }
}

}  // namespace
}  // namespace selfproj::test
