// Compares the model of the Gray-code decoder and of the median with their definitions, written out here in another
// way: from the whole history of frames, pixel by pixel, and by sorting. No test here has a tolerance.
#include "selfproj/model/gray_decoder.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "selfproj/model/median3x3.h"
#include "tests/support/random_cases.h"
#include "tests/support/reference_gray.h"

namespace selfproj::test {
namespace {

constexpr std::uint16_t kUntouched = 0x7777;
constexpr std::uint16_t kMeasurable = model::GrayDecoder::kMeasurable;

model::ImageView view_of(const GrayFrame& frame, const model::GraySettings& settings) {
  return {frame.pixels.data(), settings.rows, settings.columns, settings.columns};
}

// The code image of the model, or nothing if none is due. Checks that nothing else is touched.
std::optional<std::vector<std::uint16_t>> codes_of(model::GrayDecoder& decoder, const GrayFrame& frame) {
  const model::GraySettings settings = decoder.settings();
  std::vector<std::uint16_t> codes(frame.pixels.size(), kUntouched);
  if (decoder.add_frame(view_of(frame, settings), frame.pattern, frame.good, codes.data())) {
    return codes;
  }
  EXPECT_EQ(codes, std::vector<std::uint16_t>(frame.pixels.size(), kUntouched));
  return std::nullopt;
}

// The frame with pattern `pattern` of a scene whose pixel i has the code codes[i] (4.1): plane p of the code's Gray
// code, with 200 for lit pixels and 30 for the others.
GrayFrame frame_of_codes(const std::vector<std::uint16_t>& codes, int bits, int pattern) {
  GrayFrame frame;
  frame.pattern = pattern;
  const int shift = bits - 1 - pattern / 2;
  for (const std::uint16_t code : codes) {
    const bool lit = ((code ^ code >> 1) >> shift & 1) != 0;
    frame.pixels.push_back(lit == (pattern % 2 == 0) ? 200 : 30);
  }
  return frame;
}

TEST(GrayDecoder, EveryCodeOfEveryLength) {
  for (int bits = 1; bits <= model::GrayDecoder::kMaxBits; ++bits) {
    const int count = 1 << bits;
    std::vector<std::uint16_t> scene(static_cast<std::size_t>(count));
    std::vector<std::uint16_t> right(scene.size());
    for (int i = 0; i < count; ++i) {
      scene[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(i);
      right[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(i | kMeasurable);
    }
    model::GrayDecoder decoder({.rows = 1, .columns = count, .bits = bits, .threshold = 5});
    for (int frame = 0; frame < 6 * bits; ++frame) {
      const auto codes = codes_of(decoder, frame_of_codes(scene, bits, frame % (2 * bits)));
      const bool due = frame % 2 == 1 && frame >= 2 * bits - 1;
      ASSERT_EQ(codes.has_value(), due) << "bits " << bits << ", frame " << frame;
      if (due) {
        ASSERT_EQ(*codes, right) << "bits " << bits << ", frame " << frame;
      }
    }
  }
}

// Every difference of two pixels under some thresholds: differences strictly above or below are certain, others are
// not.
TEST(GrayDecoder, ThresholdIsStrict) {
  constexpr int kValues = 256;
  for (const int threshold : {0, 1, 5, 128, 254, 255}) {
    const model::GraySettings settings{.rows = kValues, .columns = kValues, .bits = 2, .threshold = threshold};
    model::GrayDecoder decoder(settings);
    GrayFrame positive;
    GrayFrame negative;
    for (int i = 0; i < kValues * kValues; ++i) {
      positive.pixels.push_back(static_cast<std::uint8_t>(i / kValues));
      negative.pixels.push_back(static_cast<std::uint8_t>(i % kValues));
    }
    std::optional<std::vector<std::uint16_t>> codes;
    for (int pattern = 0; pattern < 4; ++pattern) {
      GrayFrame frame = pattern % 2 == 0 ? positive : negative;
      frame.pattern = pattern;
      codes = codes_of(decoder, frame);
    }
    ASSERT_TRUE(codes.has_value());
    for (int i = 0; i < kValues * kValues; ++i) {
      const int difference = i / kValues - i % kValues;
      // Both planes see the same: G = 1 gives B = 1, then 1 xor 1 = 0; G = 0 gives 0 and 0.
      const bool ambiguous = difference <= threshold && difference >= -threshold;
      const int code = difference > threshold ? 0b10 : 0b00;
      ASSERT_EQ((*codes)[static_cast<std::size_t>(i)], code | (ambiguous ? 0 : kMeasurable))
          << "difference " << difference << ", threshold " << threshold;
    }
  }
}

// One ambiguous plane is allowed, two are not, and they are forgotten when their turn comes again.
TEST(GrayDecoder, AmbiguityWindow) {
  constexpr int kBits = 4;
  model::GrayDecoder decoder({.rows = 1, .columns = 1, .bits = kBits, .threshold = 5});
  // Whether the newest codes are measurable after pairs that are ambiguous according to `ambiguous`.
  std::vector<bool> ambiguous = {false, true, false, false, false, true, false, true, false, false, false, false};
  std::vector<int> seen;
  for (std::size_t pair = 0; pair < ambiguous.size(); ++pair) {
    const int plane = static_cast<int>(pair) % kBits;
    (void)codes_of(decoder, {.pixels = {100}, .pattern = 2 * plane});
    const std::uint8_t negative = ambiguous[pair] ? 100 : 10;
    const auto codes = codes_of(decoder, {.pixels = {negative}, .pattern = 2 * plane + 1});
    seen.push_back(codes ? (codes->front() & kMeasurable) != 0 : -1);
  }
  // pair          0   1   2   3  4  5  6  7  8  9 10 11
  // ambiguous         x               x     x
  EXPECT_EQ(seen, (std::vector<int>{-1, -1, -1, 1, 1, 1, 1, 0, 0, 1, 1, 1}));
}

TEST(GrayDecoder, WaitsForPlaneZero) {
  constexpr int kBits = 2;
  model::GrayDecoder decoder({.rows = 1, .columns = 1, .bits = kBits, .threshold = 5});
  // Each letter is a frame: its pattern index, followed by "x" if it is flagged. "!" marks those that must give a code
  // image.
  const auto dues = [&](const std::string& frames) {
    std::string result;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (frames[i] >= '0' && frames[i] <= '9') {
        const bool good = i + 1 == frames.size() || frames[i + 1] != 'x';
        const GrayFrame frame{.pixels = {50}, .pattern = frames[i] - '0', .good = good};
        result += codes_of(decoder, frame) ? '!' : '.';
      }
    }
    return result;
  };
  EXPECT_EQ(dues("0123012301"), "...!.!.!.!");
  EXPECT_EQ(dues("230123"), ".!.!.!");           // goes on
  EXPECT_EQ(dues("0x123012301"), ".......!.!");  // flagged: waits for the next plane 0
  EXPECT_EQ(dues("20123"), "....!");             // one came out of turn
  EXPECT_EQ(dues("01"), ".!");
  EXPECT_EQ(dues("3230123"), "......!");  // 2 is missing
  EXPECT_EQ(dues("00123"), "....!");      // the second 0 is not the next, but it is plane 0
  EXPECT_EQ(dues("0112301"), ".!.....");  // 1 comes twice
  EXPECT_EQ(dues("23"), ".!");
  EXPECT_EQ(dues("4"), ".");  // no such pattern
  EXPECT_EQ(dues("230123"), ".....!");
  decoder.restart();
  EXPECT_EQ(dues("0123"), "...!");
  decoder.configure(decoder.settings());  // no change
  EXPECT_EQ(dues("01"), ".!");
  model::GraySettings settings = decoder.settings();
  settings.threshold = 6;
  decoder.configure(settings);
  EXPECT_EQ(dues("2301"), "....");
  EXPECT_EQ(dues("23"), ".!");
}

// Random sequences with everything that can happen, against the reference.
TEST(GrayDecoder, RandomSequences) {
  for (const std::uint64_t seed : seeds(120)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    model::GraySettings settings{.rows = random.between(1, 5),
                                 .columns = random.between(1, 40),
                                 .bits = static_cast<int>(seed % model::GrayDecoder::kMaxBits) + 1,
                                 .threshold = random.chance(20) ? random.between(0, 255) : random.between(0, 12)};
    model::GrayDecoder decoder(settings);
    ReferenceGray reference(settings);
    GraySequence sequence(settings, random);
    int images = 0;
    for (int i = 0; i < 20 * settings.bits; ++i) {
      if (random.chance(1)) {
        decoder.restart();
        reference.restart();
      }
      const GrayFrame frame = sequence.next();
      const auto right = reference.take(frame);
      const auto codes = codes_of(decoder, frame);
      ASSERT_EQ(codes, right) << "frame " << i << " of m = " << settings.bits;
      images += codes ? 1 : 0;
    }
    EXPECT_TRUE(images > 0 || settings.bits > 4);
  }
}

// Piece by piece with a break in the middle: the lines before it are decoded, and then the decoder waits for plane 0.
TEST(GrayDecoder, BrokenFrame) {
  const model::GraySettings settings{.rows = 2, .columns = 3, .bits = 1, .threshold = 5};
  model::GrayDecoder decoder(settings);
  const std::array<std::uint8_t, 6> bright = {200, 200, 200, 200, 200, 200};
  const std::array<std::uint8_t, 6> dark{};
  std::array<std::uint16_t, 3> codes{};
  EXPECT_FALSE(decoder.begin(0));
  decoder.pixels(0, 0, 3, bright.data(), nullptr);
  decoder.pixels(1, 0, 3, bright.data() + 3, nullptr);
  decoder.end(true);
  EXPECT_TRUE(decoder.begin(1));
  decoder.pixels(0, 0, 3, dark.data(), codes.data());
  EXPECT_EQ(codes, (std::array<std::uint16_t, 3>{1 | kMeasurable, 1 | kMeasurable, 1 | kMeasurable}));
  codes.fill(kUntouched);
  decoder.pixels(1, 0, 2, dark.data() + 3, codes.data());
  EXPECT_EQ(codes, (std::array<std::uint16_t, 3>{1 | kMeasurable, 1 | kMeasurable, kUntouched}));
  decoder.pixels(1, 2, 1, dark.data() + 5, codes.data() + 2);
  EXPECT_EQ(codes, (std::array<std::uint16_t, 3>{1 | kMeasurable, 1 | kMeasurable, 1 | kMeasurable}));
  decoder.end(false);
  EXPECT_FALSE(decoder.begin(1));
  decoder.end(true);
  EXPECT_FALSE(decoder.begin(0));
  decoder.end(true);
  EXPECT_TRUE(decoder.begin(1));
}

TEST(GrayDecoder, RefusesWhatIsOutOfRange) {
  const model::GraySettings good{.rows = 4, .columns = 8, .bits = 3, .threshold = 5};
  for (const auto change : std::vector<void (*)(model::GraySettings&)>{
           [](model::GraySettings& s) { s.rows = 0; }, [](model::GraySettings& s) { s.columns = 0; },
           [](model::GraySettings& s) { s.bits = 0; },
           [](model::GraySettings& s) { s.bits = model::GrayDecoder::kMaxBits + 1; },
           [](model::GraySettings& s) { s.threshold = -1; }, [](model::GraySettings& s) { s.threshold = 256; }}) {
    model::GraySettings bad = good;
    change(bad);
    EXPECT_THROW(model::GrayDecoder decoder(bad), std::invalid_argument);
    model::GrayDecoder decoder(good);
    EXPECT_THROW(decoder.configure(bad), std::invalid_argument);
    EXPECT_EQ(decoder.settings(), good);
  }
  model::GrayDecoder decoder(good);
  const std::vector<std::uint8_t> pixels(32);
  std::vector<std::uint16_t> codes(32);
  EXPECT_THROW(decoder.add_frame({pixels.data(), 3, 8, 8}, 0, true, codes.data()), std::invalid_argument);
  EXPECT_THROW(decoder.add_frame({pixels.data(), 4, 7, 8}, 0, true, codes.data()), std::invalid_argument);
  EXPECT_THROW(decoder.add_frame({nullptr, 4, 8, 8}, 0, true, codes.data()), std::invalid_argument);
  EXPECT_THROW(decoder.add_frame({pixels.data(), 4, 8, 8}, 0, true, nullptr), std::invalid_argument);
}

TEST(Median3x3, SmallImagesByHand) {
  const auto median = [](std::vector<std::uint16_t> codes, int rows, int columns) {
    std::vector<std::uint16_t> out(codes.size(), kUntouched);
    model::median3x3(codes.data(), rows, columns, out.data());
    return out;
  };
  constexpr std::uint16_t kM = kMeasurable;
  EXPECT_EQ(median({5 | kM}, 1, 1), (std::vector<std::uint16_t>{5 | kM}));
  EXPECT_EQ(median({5}, 1, 1), (std::vector<std::uint16_t>{0}));
  // Two: both, the lower one; one of two is not more than half.
  EXPECT_EQ(median({9 | kM, 5 | kM}, 1, 2), (std::vector<std::uint16_t>{5 | kM, 5 | kM}));
  EXPECT_EQ(median({9 | kM, 5}, 1, 2), (std::vector<std::uint16_t>{0, 0}));
  // A hole is filled from its eight neighbours: 1 2 3 4 | 6 7 8 9, the lower middle is 4.
  EXPECT_EQ(median({1 | kM, 2 | kM, 3 | kM, 4 | kM, 5, 6 | kM, 7 | kM, 8 | kM, 9 | kM}, 3, 3)[4], 4 | kM);
  // Four of nine are not enough, five are.
  EXPECT_EQ(median({1 | kM, 2 | kM, 3 | kM, 4 | kM, 5, 6, 7, 8, 9}, 3, 3)[4], 0);
  EXPECT_EQ(median({1 | kM, 2 | kM, 3 | kM, 4 | kM, 5, 6 | kM, 7, 8, 9}, 3, 3)[4], 3 | kM);
}

TEST(Median3x3, RandomImages) {
  for (const std::uint64_t seed : seeds(200)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(1, 12);
    const int columns = random.between(1, 20);
    const int percent = random.between(0, 100);
    std::vector<std::uint16_t> codes(static_cast<std::size_t>(rows * columns));
    for (std::uint16_t& code : codes) {
      code = static_cast<std::uint16_t>(random.between(0, random.chance(50) ? 4095 : 7) |
                                        (random.chance(percent) ? kMeasurable : 0));
    }
    std::vector<std::uint16_t> out(codes.size(), kUntouched);
    model::median3x3(codes.data(), rows, columns, out.data());
    ASSERT_EQ(out, reference_median(codes, rows, columns)) << rows << " x " << columns;
  }
}

TEST(Median3x3, RefusesWhatIsOutOfRange) {
  std::uint16_t word = 0;
  EXPECT_THROW(model::median3x3(&word, 0, 1, &word), std::invalid_argument);
  EXPECT_THROW(model::median3x3(&word, 1, 0, &word), std::invalid_argument);
  EXPECT_THROW(model::median3x3(nullptr, 1, 1, &word), std::invalid_argument);
  EXPECT_THROW(model::median3x3(&word, 1, 1, nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
