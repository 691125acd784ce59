// Boards for pixels of 12 and 10 bits, and for 8 and 16 pixels a clock, beside the model, packet by packet and byte by
// byte.
#include <gtest/gtest.h>

#include <cstdint>
#include <tuple>
#include <type_traits>
#include <vector>

#include "Vboard_codes_sixteen.h"
#include "Vboard_eight.h"
#include "Vboard_eight_of_twelve.h"
#include "Vboard_sixteen.h"
#include "Vboard_tall.h"
#include "Vboard_tall_binary.h"
#include "Vboard_tall_of_ten.h"
#include "Vboard_ten.h"
#include "Vboard_twelve.h"
#include "Vboard_verdict_eight_of_twelve.h"
#include "Vboard_verdict_sixteen_of_ten.h"
#include "Vboard_widest.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/racing_board.h"
#include "tests/rtl/board/random_codes.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/rtl/board/verdict_board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(WideBoard, RandomFramesOfTwelveBitsEqualTheModel) {
  play_all_random_frames<Vboard_twelve>(40, {.pixel_bits = 12, .runs = true, .compact = true});
}
TEST(WideBoard, RandomFaultsOfTwelveBitsEqualTheModel) {
  play_all_random_frames<Vboard_twelve>(
      30, {.max_columns = 40, .max_rows = 12, .pixel_bits = 12, .runs = true, .compact = true, .fault_percent = 40});
}
TEST(WideBoard, RandomFramesOfTenBitsEqualTheModel) {
  play_all_random_frames<Vboard_ten>(
      40, {.pixel_bits = 10, .image = false, .runs = true, .region = false, .fault_percent = 10});
}

TEST(WideBoard, RandomFramesOfEightLanesEqualTheModel) {
  play_all_random_frames<Vboard_eight>(60, {.lanes = 8, .runs = true, .compact = true});
}
TEST(WideBoard, RandomFaultsOfEightLanesEqualTheModel) {
  play_all_random_frames<Vboard_eight>(
      40, {.max_columns = 512, .max_rows = 12, .lanes = 8, .runs = true, .compact = true, .fault_percent = 40});
}
TEST(WideBoard, RandomFramesOfEightLanesOfTwelveBitsEqualTheModel) {
  play_all_random_frames<Vboard_eight_of_twelve>(40, {.pixel_bits = 12, .lanes = 8, .runs = true, .fault_percent = 10});
}
TEST(WideBoard, RandomFramesOfSixteenLanesEqualTheModel) {
  play_all_random_frames<Vboard_sixteen>(
      60, {.max_columns = 512, .lanes = 16, .runs = true, .region = false, .compact = true, .fault_percent = 20});
}

TEST(WideBoard, RandomFramesOfManyColumnsEqualTheModel) {
  play_all_random_frames<Vboard_sixteen>(4, {.max_columns = 4096,
                                             .max_rows = 12,
                                             .lanes = 16,
                                             .runs = true,
                                             .region = false,
                                             .compact = true,
                                             .changes = 40});
  play_all_random_frames<Vboard_widest>(
      12, {.max_columns = 4096, .max_rows = 15, .runs = true, .compact = true, .fault_percent = 10, .changes = 40});
}

// Words of columns of a build for more than 1,023 rows, in short frames and in tall ones.
TEST(WideBoard, RandomFramesOfManyRowsEqualTheModel) {
  RandomFrames limits{.max_rows = spec::kRowLimit, .runs = true, .compact = true, .changes = 25};
  play_all_random_frames<Vboard_tall>(10, limits);
  limits.fault_percent = 20;
  play_all_random_frames<Vboard_tall>(6, limits);
  play_all_random_frames<Vboard_tall_of_ten>(10, {.max_rows = spec::kRowLimit,
                                                  .pixel_bits = 10,
                                                  .lanes = 8,
                                                  .region = false,
                                                  .compact = true,
                                                  .fault_percent = 10,
                                                  .changes = 25});
  play_all_random_frames<Vboard_tall_binary>(
      10, {.max_rows = spec::kRowLimit, .grey = false, .image = false, .runs = true, .region = false, .changes = 25});
}

// The brightest frame of 2,047 rows fills every field; registers take rows up to it, and `capability` says 0.
TEST(WideBoard, TwoThousandRows) {
  constexpr int kRows = spec::kRowLimit, kColumns = 16;
  const auto play = [&]<class Board>(Scoreboard<Board>& board, int bits, int lanes, bool compact) {
    EXPECT_EQ(board.device().read(spec::kRegCapability) >> spec::kRegCapabilityMaxRowsLsb &
                  ((1U << spec::kRegCapabilityMaxRowsBits) - 1),
              0U);
    const auto refused = [&](std::uint32_t address, std::uint32_t word) {
      return board.device().access(true, address, word).error;
    };
    const auto size = [&](std::uint32_t rows) { return rows << spec::kRegSizeRowsLsb | kColumns; };
    EXPECT_TRUE(refused(spec::kRegSize, size(kRows + 1)));
    EXPECT_FALSE(refused(spec::kRegSize, size(kRows)));
    const std::uint32_t window = 1500U << spec::kRegWindowFirstLsb | 2047U << spec::kRegWindowLastLsb;
    EXPECT_FALSE(refused(spec::kRegWindow, window));
    EXPECT_EQ(board.device().read(spec::kRegWindow), window);
    int frames = 0;
    for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
      for (const model::RowWindow& counts : {model::RowWindow{}, model::RowWindow{1024, 2046}}) {
        board.write(
            {.columns = kColumns, .rows = kRows, .mode = mode, .threshold = 0, .window = counts, .compact = compact});
        for (const auto& line : lines_of(constant_image(kRows, kColumns, 0), lanes)) {
          for (model::VideoBeat beat : line) {
            beat.pixels.fill(static_cast<std::uint16_t>((1 << bits) - 1));
            board.device().send(beat);
          }
        }
        board.play();
        ++frames;
      }
    }
    board.finish();
    EXPECT_EQ(board.delivered(spec::kKindMoments), static_cast<unsigned>(frames));  // compact ones among them
    EXPECT_EQ(board.last_header(spec::kKindMoments).rows, kRows);
    EXPECT_TRUE(board.last_header(spec::kKindMoments).tall);
  };
  for (const bool compact : {false, true}) {
    Scoreboard<Vboard_tall> eight({}, true, true);
    play(eight, 8, 4, compact);
    Scoreboard<Vboard_tall_of_ten> ten({.pixel_bits = 10, .lanes = 8}, true, true);
    play(ten, 10, 8, compact);
  }
}

// The widest frame: its size in the registers, every packet of it, and its codes.
TEST(WideBoard, FourThousandColumns) {
  constexpr int kColumns = spec::kColumnLimit, kRows = 6;
  Scoreboard<Vboard_widest> board;
  EXPECT_EQ(board.device().read(spec::kRegCapability) & 0xFFFU, 0U);
  const auto size = [&](unsigned columns) {
    return board.device()
        .access(true, spec::kRegSize, columns << spec::kRegSizeColumnsLsb | 8U << spec::kRegSizeRowsLsb)
        .error;
  };
  EXPECT_TRUE(size(kColumns + 4));
  EXPECT_TRUE(size(0x2000));
  EXPECT_FALSE(size(kColumns));
  board.count_patterns_on_frames(3);
  Random random(1);
  for (const bool compact : {false, true}) {
    board.write({.image = true,
                 .columns = kColumns,
                 .rows = kRows,
                 .mode = model::Mode::grey,
                 .threshold = 100,
                 .select = model::Select::strongest,
                 .compact = compact,
                 .codes = true,
                 .median = true,
                 .code_bits = 2,
                 .code_threshold = 5});
    for (int frame = 0; frame < 8; ++frame) {
      board.send(random, random_image(random, kRows, kColumns), 0);
      board.device().gap(8 * kColumns);
    }
    board.play();
  }
  board.finish();
  EXPECT_EQ(board.delivered(spec::kKindMoments), 16U);  // compact ones among them
  EXPECT_EQ(board.delivered(spec::kKindImage), 16U * kRows);
  EXPECT_GE(board.delivered(spec::kKindCodes), 2U * kRows);
}

// Counts of all columns, where registers have 12 bits.
TEST(WideBoard, VerdictsOfFourThousandColumns) {
  constexpr int kColumns = spec::kColumnLimit, kRows = 12;
  VerdictBoard<Vboard_widest> bench;
  bench.write(spec::kRegEjectorDelay, 0);
  bench.write(spec::kRegEjectorLength, 1);
  for (int column = 0; column < kColumns; ++column) {
    ASSERT_TRUE(bench.write_limits(0, 0, column, {.low = 0, .high = model::kRowParts * 12, .judged = true}));
  }
  int lacking = 0;
  for (const int most_unlit : {model::kUnlitNotJudged - 1, model::kUnlitNotJudged}) {
    bench.write({.columns = kColumns,
                 .rows = kRows,
                 .mode = model::Mode::binary,
                 .threshold = 100,
                 .verdict = true,
                 .verdict_packets = 1,
                 .verdict_settings = {.width = 200, .history = 1, .hits = 1, .most_unlit = most_unlit},
                 .part_rule = {.lit = 4095, .dark_frames = 3}});
    for (const int value : {200, 0, 200, 0, 0, 0, 0}) {  // the part begins behind its first frame, and ends
      bench.device().send(constant_image(kRows, kColumns, static_cast<std::uint8_t>(value)).view());
      bench.device().gap(3 * kColumns);
    }
    bench.board().play();
    bench.device().drain(kApart);
    EXPECT_EQ(bench.verdict().parts(), static_cast<std::uint64_t>(++lacking));
    EXPECT_EQ(bench.verdict().bad_parts(), 1U);  // where light is judged
  }
  bench.board().finish();
  EXPECT_EQ(bench.board().delivered(spec::kKindMoments), 14U);
}

// Verdicts, which take 16 bytes a clock.
template <class Board>
void play_all_verdicts(int fault_percent) {
  constexpr int kCases = 4;
  VerdictCounts seen;
  for_cases(kCases, [&](std::uint64_t seed) { play_verdicts<Board>(seed, fault_percent, 40, seen); });
  if (runs_all_cases()) {
    EXPECT_GT(seen.delivered, seen.frames / 2);
    EXPECT_TRUE(seen.lost > 0 || kBuild<Board>.max_columns > 64);  // those have FIFOs for more than the bus stalls
    EXPECT_GT(seen.parts, 10U * kCases);
    EXPECT_GT(seen.bad, kCases);
  }
}
TEST(WideBoard, VerdictsOfTwelveBitsEqualTheModel) {
  play_all_verdicts<Vboard_twelve>(0);
  play_all_verdicts<Vboard_twelve>(30);
}
TEST(WideBoard, VerdictsOfEightAndSixteenLanesEqualTheModel) {
  play_all_verdicts<Vboard_eight>(0);
  play_all_verdicts<Vboard_eight>(30);
  play_all_verdicts<Vboard_sixteen>(0);
}
TEST(WideBoard, VerdictsOfEightLanesOfTwelveBitsEqualTheModel) {
  play_all_verdicts<Vboard_verdict_eight_of_twelve>(0);
  play_all_verdicts<Vboard_verdict_eight_of_twelve>(30);
}
TEST(WideBoard, VerdictsOfSixteenLanesOfTenBitsEqualTheModel) {
  play_all_verdicts<Vboard_verdict_sixteen_of_ten>(0);
  play_all_verdicts<Vboard_verdict_sixteen_of_ten>(30);
}

TEST(WideBoard, VerdictsTakeSoLong) {
  using Eight = Vboard_verdict_eight_of_twelve;
  using Sixteen = Vboard_verdict_sixteen_of_ten;
  constexpr int kColumns = 64, kFrames = 10;
  for (const auto& [mode, eight, sixteen] : {std::tuple{model::Mode::binary, 17, 32}, {model::Mode::grey, 19, 37}}) {
    EXPECT_EQ(missed_frames<Eight>(kColumns, eight, mode, kFrames), 0U);
    EXPECT_GT(missed_frames<Eight>(kColumns, eight - 1, mode, kFrames), 0U);
    EXPECT_EQ(missed_frames<Sixteen>(kColumns, sixteen, mode, kFrames), 0U);
    EXPECT_GT(missed_frames<Sixteen>(kColumns, sixteen - 1, mode, kFrames), 0U);
  }
  EXPECT_EQ(clocks_to_the_pin<Eight>(kColumns, model::Mode::binary), 52);
  EXPECT_EQ(clocks_to_the_pin<Eight>(kColumns, model::Mode::grey), 67);
  EXPECT_EQ(clocks_to_the_pin<Sixteen>(kColumns, model::Mode::binary), 46);
  EXPECT_EQ(clocks_to_the_pin<Sixteen>(kColumns, model::Mode::grey), 68);
}

// Frames without a gap between them, and a bus that never stalls: 40 clocks more than a packet has payload beats are
// enough for every packet (sp_payload_split), and no more clocks than beats are not.
template <class Board>
void frames_close_together(int lanes, model::Mode mode, bool compact = false) {
  for (const int columns : {lanes, 2 * lanes, 8 * lanes, 256, 512}) {
    const int groups = columns / lanes;
    const int beats = columns / (mode == model::Mode::binary || compact ? 4 : 2);
    const int more = compact ? 40 + 7 : 40;  // MaxRows has 7 bits
    const auto lost_of = [&](int rows) {
      Scoreboard<Board> board({.bus_period_ps = 4000, .lanes = lanes});
      board.write({.columns = columns,
                   .rows = rows,
                   .mode = mode,
                   .threshold = 100,
                   .select = model::Select::strongest,
                   .compact = compact});
      Random random(1);
      for (int frame = 0; frame < 40; ++frame) {
        board.send(random, random_image(random, rows, columns), 0);
      }
      board.play();
      board.finish();
      return board.lost(spec::kKindMoments);
    };
    SCOPED_TRACE(::testing::Message() << lanes << " lanes, " << columns << " columns");
    EXPECT_EQ(lost_of((beats + more + groups - 1) / groups), 0U);
    EXPECT_GT(lost_of(beats / groups), 0U);
  }
}
TEST(WideBoard, FramesCloseTogether) {
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    frames_close_together<Vboard_eight>(8, mode);
    frames_close_together<Vboard_sixteen>(16, mode);
  }
  frames_close_together<Vboard_eight>(8, model::Mode::grey, true);
  frames_close_together<Vboard_sixteen>(16, model::Mode::grey_over, true);
}

// Lines of raw images, or of codes, that come `gap` clocks after each other, and a bus that never stalls: how many are
// lost.
template <class Board>
std::uint64_t lost_lines(int lanes, int columns, std::uint32_t gap, std::uint8_t kind = spec::kKindImage,
                         bool median = false) {
  constexpr int kRows = 40;
  const bool codes = kind == spec::kKindCodes;
  constexpr int kBits = std::is_same_v<Board, Vboard_eight_of_twelve> ? 12 : spec::kPixelBits;
  Scoreboard<Board> board({.bus_period_ps = 3000, .pixel_bits = kBits, .lanes = lanes});
  if (codes) {
    board.count_patterns_on_frames(1);
  }
  board.write({.image = !codes,
               .columns = columns,
               .rows = kRows,
               .threshold = 100,
               .codes = codes,
               .median = median,
               .code_bits = 1});
  Random random(1);
  for (int frame = 0; frame < (codes ? 2 : 1); ++frame) {  // codes come with the second of a pair
    for (const auto& line : lines_of(random_image(random, kRows, columns), lanes)) {
      for (const model::VideoBeat& beat : line) {
        board.device().send(beat);
      }
      board.device().gap(gap);
    }
  }
  board.play();
  board.finish();
  EXPECT_EQ(board.delivered(kind) + board.lost(kind), static_cast<std::uint64_t>(kRows));
  return board.lost(kind);
}

// As sp_image_path and sp_codes_path state it
TEST(WideBoard, LinesCloseTogether) {
  EXPECT_EQ(lost_lines<Vboard_eight>(8, 176, 0), 0U);
  EXPECT_EQ(lost_lines<Vboard_eight>(8, 512, 0), 0U);
  EXPECT_GT(lost_lines<Vboard_eight>(8, 168, 0), 0U);
  EXPECT_EQ(lost_lines<Vboard_sixteen>(16, 176, 11), 0U);
  EXPECT_EQ(lost_lines<Vboard_sixteen>(16, 512, 11), 0U);
  EXPECT_GT(lost_lines<Vboard_sixteen>(16, 512, 10), 0U);
  for (const bool median : {false, true}) {
    const auto lost_codes = [&](int lanes, int columns, int gap) {
      const auto clocks = static_cast<std::uint32_t>(gap);
      return lanes == 16 ? lost_lines<Vboard_codes_sixteen>(16, columns, clocks, spec::kKindCodes, median)
                         : lost_lines<Vboard_eight_of_twelve>(8, columns, clocks, spec::kKindCodes, median);
    };
    for (const int columns : {16, 64}) {
      EXPECT_EQ(lost_codes(8, columns, 11), 0U);
      EXPECT_GT(lost_codes(8, columns, 10), 0U);
    }
    for (const int columns : {16, 48, 256}) {
      EXPECT_EQ(lost_codes(16, columns, columns / 16 + 11), 0U);
      EXPECT_GT(lost_codes(16, columns, columns / 16 + 10), 0U);
    }
  }
}

// Columns that beats cannot have are refused; `status` says how many pixels a beat has.
TEST(WideBoard, RegistersOfMoreLanes) {
  Scoreboard<Vboard_eight> eight({.lanes = 8});
  Scoreboard<Vboard_sixteen> sixteen({.lanes = 16});
  const auto lanes = [](auto& board) {
    return spec::kPixelsPerBeat << (board.device().read(spec::kRegStatus) >> spec::kRegStatusLanesLsb &
                                    ((1U << spec::kRegStatusLanesBits) - 1));
  };
  EXPECT_EQ(lanes(eight), 8);
  EXPECT_EQ(lanes(sixteen), 16);
  const auto refused = [](auto& board, std::uint32_t columns) {
    return board.device()
        .access(true, spec::kRegSize, columns << spec::kRegSizeColumnsLsb | 8U << spec::kRegSizeRowsLsb)
        .error;
  };
  EXPECT_FALSE(refused(eight, 8));
  EXPECT_TRUE(refused(eight, 12));
  EXPECT_FALSE(refused(sixteen, 48));
  EXPECT_TRUE(refused(sixteen, 40));
}

TEST(WideBoard, WritesThatRaceFrameStarts) {
  RaceCounts counts;
  for_cases(
      10, [&](std::uint64_t seed) { play_races<Vboard_eight_of_twelve>(seed, 250, counts, {.bits = 12, .lanes = 8}); });
  if (runs_all_cases()) {
    EXPECT_GT(counts.racing, 500U);
    EXPECT_GT(counts.frames - counts.broken, counts.frames / 2);
  }
}

// Images and codes are of the upper eight bits.
TEST(WideBoard, CodesOfTwelveBitsEqualTheModel) {
  CodeCounts counts;
  for_cases(20, [&](std::uint64_t seed) { play_random_sequences<Vboard_twelve>(seed, true, 10, counts, {}, {}, 12); });
  if (runs_all_cases()) {
    EXPECT_GT(counts.delivered, counts.frames / 8) << "too little of the decoder was seen";
  }
}

TEST(WideBoard, CodesOfEightLanesEqualTheModel) {
  CodeCounts counts;
  for_cases(40, [&](std::uint64_t seed) {
    play_random_sequences<Vboard_eight_of_twelve>(seed, true, 10, counts, {}, {}, 12, 8);
  });
  if (runs_all_cases()) {
    EXPECT_GT(counts.delivered, counts.frames / 8) << "too little of the decoder was seen";
  }
}

TEST(WideBoard, CodesOfSixteenLanesEqualTheModel) {
  CodeCounts counts;
  for_cases(40, [&](std::uint64_t seed) {
    play_random_sequences<Vboard_codes_sixteen>(seed, true, 10, counts, {}, {}, spec::kPixelBits, 16);
  });
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
