// Boards for pixels of 12 and 10 bits beside the model, packet by packet and byte by byte.
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "Vboard_ten.h"
#include "Vboard_twelve.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/random_codes.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(WideBoard, RandomFramesOfTwelveBitsEqualTheModel) {
  play_all_random_frames<Vboard_twelve>(40, {.pixel_bits = 12});
}
TEST(WideBoard, RandomFaultsOfTwelveBitsEqualTheModel) {
  play_all_random_frames<Vboard_twelve>(30, {.max_columns = 40, .max_rows = 12, .pixel_bits = 12, .fault_percent = 40});
}
TEST(WideBoard, RandomFramesOfTenBitsEqualTheModel) {
  play_all_random_frames<Vboard_ten>(40, {.pixel_bits = 10, .image = false, .region = false, .fault_percent = 10});
}

// Images and codes are of the upper eight bits.
TEST(WideBoard, CodesOfTwelveBitsEqualTheModel) {
  CodeCounts counts;
  for_cases(20, [&](std::uint64_t seed) { play_random_sequences<Vboard_twelve>(seed, true, 10, counts, {}, {}, 12); });
  if (runs_all_cases()) {
    EXPECT_GT(counts.delivered, counts.frames / 8) << "too little of the decoder was seen";
  }
}

// What a frame of 127 rows sums up to at most: all pixels 1023, in every mode.
TEST(WideBoard, TheBrightestFrame) {
  constexpr int kColumns = 512;
  constexpr int kRows = 127;
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    Scoreboard<Vboard_ten> board({.pixel_bits = 10});
    board.write({.columns = kColumns, .rows = kRows, .mode = mode, .threshold = 0});
    for (const auto& line : lines_of(constant_image(kRows, kColumns, 0))) {
      for (model::VideoBeat beat : line) {
        beat.pixels.fill(1023);
        board.device().send(beat);
      }
    }
    board.finish();
    EXPECT_EQ(board.delivered(spec::kKindMoments), 1U);
    EXPECT_EQ(board.last_header(spec::kKindMoments).pixel_bits, 10);
  }
}

// A threshold that the pixels cannot have is refused, and the register keeps its value; `status` says how many bits a
// pixel has.
TEST(WideBoard, RegistersOfMoreBits) {
  Scoreboard<Vboard_ten> ten({.pixel_bits = 10});
  Scoreboard<Vboard_twelve> twelve({.pixel_bits = 12});
  const auto more_bits = [](auto& board) {
    return board.device().read(spec::kRegStatus) >> spec::kRegStatusMoreBitsLsb &
           ((1U << spec::kRegStatusMoreBitsBits) - 1);
  };
  EXPECT_EQ(more_bits(ten), 2U);
  EXPECT_EQ(more_bits(twelve), 4U);
  const auto word = [](std::uint32_t threshold) {
    return (threshold & 0xFF) << spec::kRegMeasureThresholdLsb | threshold >> 8 << spec::kRegMeasureThresholdHighLsb;
  };
  EXPECT_FALSE(ten.device().access(true, spec::kRegMeasure, word(1023)).error);
  EXPECT_TRUE(ten.device().access(true, spec::kRegMeasure, word(1024)).error);
  EXPECT_EQ(ten.device().read(spec::kRegMeasure), word(1023));
  EXPECT_FALSE(twelve.device().access(true, spec::kRegMeasure, word(4095)).error);
  EXPECT_EQ(twelve.device().read(spec::kRegMeasure), word(4095));
}

}  // namespace
}  // namespace selfproj::test
