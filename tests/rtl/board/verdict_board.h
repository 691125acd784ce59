// Boards with verdicts beside the models of its packets and of its registers, and random frames for both.
#ifndef SELFPROJ_TESTS_RTL_BOARD_VERDICT_BOARD_H
#define SELFPROJ_TESTS_RTL_BOARD_VERDICT_BOARD_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "model/register_file.h"
#include "selfproj/model/verdict.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

// The boards; their sources include those that they use.
class Vboard_verdict;
class Vboard_verdict_binary;
class Vboard_verdict_eight_of_twelve;
class Vboard_verdict_sixteen_of_ten;
class Vboard_widest;
class Vboard_twelve;
class Vboard_eight;
class Vboard_sixteen;

namespace selfproj::test {

template <class Model>
inline constexpr model::BoardBuild kBuild = {};  // of no board here: it has no verdict
template <>
inline constexpr model::BoardBuild kBuild<Vboard_verdict> = {
    .max_columns = 64, .max_rows = 40, .runs = true, .region = true, .compact = true, .verdict_log_sections = 1};
template <>
inline constexpr model::BoardBuild kBuild<Vboard_verdict_binary> = {
    .max_columns = 512, .max_rows = 127, .grey = false, .image = false, .verdict_log_sections = 0};
template <>
inline constexpr model::BoardBuild kBuild<Vboard_verdict_eight_of_twelve> = {.max_columns = 64,
                                                                             .max_rows = 80,
                                                                             .pixel_bits = 12,
                                                                             .lanes = 8,
                                                                             .runs = true,
                                                                             .region = true,
                                                                             .compact = true,
                                                                             .verdict_log_sections = 1};
template <>
inline constexpr model::BoardBuild kBuild<Vboard_verdict_sixteen_of_ten> = {
    .max_columns = 64, .max_rows = 127, .pixel_bits = 10, .lanes = 16, .region = true, .verdict_log_sections = 1};
template <>
inline constexpr model::BoardBuild kBuild<Vboard_widest> = {.max_columns = 4096,
                                                            .max_rows = 15,
                                                            .codes = true,
                                                            .median = true,
                                                            .runs = true,
                                                            .region = true,
                                                            .compact = true,
                                                            .verdict_log_sections = 0,
                                                            .code_bits = 8};
template <>
inline constexpr model::BoardBuild kBuild<Vboard_twelve> = {.max_columns = 64,
                                                            .max_rows = 40,
                                                            .pixel_bits = 12,
                                                            .codes = true,
                                                            .median = true,
                                                            .runs = true,
                                                            .region = true,
                                                            .compact = true,
                                                            .verdict_log_sections = 1,
                                                            .code_bits = 12};
template <>
inline constexpr model::BoardBuild kBuild<Vboard_eight> = {.max_columns = 512,
                                                           .max_rows = 127,
                                                           .lanes = 8,
                                                           .runs = true,
                                                           .region = true,
                                                           .compact = true,
                                                           .verdict_log_sections = 1};
template <>
inline constexpr model::BoardBuild kBuild<Vboard_sixteen> = {
    .max_columns = 4096, .max_rows = 127, .lanes = 16, .runs = true, .compact = true, .verdict_log_sections = 1};
constexpr int kApart = 200;  // clocks between frames, more than the verdict of a frame takes

// The board, the model of its packets, and the model of its registers.
template <class Model>
class VerdictBoard {
  static_assert(kBuild<Model>.verdict_log_sections >= 0);

 public:
  explicit VerdictBoard(const sim::BoardDeviceOptions& options = {.pixel_bits = kBuild<Model>.pixel_bits,
                                                                  .lanes = kBuild<Model>.lanes})
      : board_(options) {
    board_.model().judge_with(verdict_);
    registers_.judge_with(verdict_);
  }

  Scoreboard<Model>& board() { return board_; }
  sim::BoardDevice<Model>& device() { return board_.device(); }
  model::Verdict& verdict() { return verdict_; }

  // The same access to the board and to the model of its registers: both take it, or both refuse it.
  bool access(bool write, std::uint32_t address, std::uint32_t data = 0) {
    const model::RegisterAnswer got = device().access(write, address, data);
    const model::RegisterAnswer wanted =
        write ? registers_.write(address, data)
              : registers_.read(address, {.frame_open = board_.model().frame_open(),
                                          .frames = static_cast<std::uint32_t>(board_.model().frames())});
    EXPECT_EQ(got.error, wanted.error) << "address " << address << ", data " << data;
    if (!write && !wanted.error) {
      EXPECT_EQ(got.data, wanted.data) << "address " << address;
    }
    return !got.error;
  }
  bool write(std::uint32_t address, std::uint32_t data) { return access(true, address, data); }

  // All settings of the verdict, through both.
  void write(const model::BoardSettings& settings) {
    for (const auto& [address, data] : model::verdict_writes(settings.verdict_settings, settings.part_rule)) {
      write(address, data);
    }
    write(spec::kRegVerdictControl,
          model::verdict_control_word(settings.verdict, settings.verdict_hold, settings.part_rule.by_encoder,
                                      settings.verdict_packets));
    board_.write(settings);
  }

  // Limits of a column. Returns whether they were taken.
  bool write_limits(int bank, int section, int column, const model::ColumnLimits& limits) {
    aim(bank, section, column);
    return write(spec::kRegVerdictLimits, model::limits_word(limits));
  }
  bool begin_section(int bank, int section, std::uint32_t counts) {
    aim(bank, section, 0);
    return write(spec::kRegVerdictBegin, counts);
  }

 private:
  void aim(int bank, int section, int column) {
    write(spec::kRegVerdictTable, static_cast<std::uint32_t>(column) << spec::kRegVerdictTableColumnLsb |
                                      static_cast<std::uint32_t>(section) << spec::kRegVerdictTableSectionLsb |
                                      static_cast<std::uint32_t>(bank) << spec::kRegVerdictTableBankLsb);
  }

  model::Verdict verdict_{kBuild<Model>.max_columns, 1 << kBuild<Model>.verdict_log_sections};
  Scoreboard<Model> board_;
  model::RegisterFile registers_{kBuild<Model>};
};

// Half of the limits lie where centroids of few lit rows do, M1 / M0, or 1/128 beside them.
inline model::ColumnLimits random_limits(Random& random, const model::BoardBuild& build, int rows) {
  const int highest = model::kRowParts * build.max_rows;
  const int middle = model::kRowParts * random.between(1, std::min(rows, build.max_rows - 4));
  const int band = random.between(0, 3 * model::kRowParts);
  int low = middle - band, high = middle + band;
  if (random.chance(50)) {
    const int m0 = random.between(1, 9);
    const auto centroid = [&](int limit) {
      return limit * m0 / model::kRowParts * model::kRowParts / m0 + random.between(-1, 1);
    };
    low = centroid(low);
    high = std::max(low, centroid(high));
  }
  return {.low = static_cast<std::uint32_t>(std::max(0, low)),
          .high = static_cast<std::uint32_t>(std::clamp(high, 0, highest)),
          .judged = random.chance(90)};
}

// All frames of a part have the same columns.
inline model::BoardSettings random_settings(Random& random, const model::BoardBuild& build, int columns,
                                            std::uint32_t encoder, int least_rows) {
  const int history = random.between(1, model::kMaxHistory);
  const auto length = static_cast<std::uint32_t>(random.between(1, 60));
  const int rows = random.between(least_rows, least_rows + 9);
  const bool strongest = build.runs && random.chance(40);
  const int more_bits = build.pixel_bits - spec::kPixelBits;
  return {.hold = random.chance(15),
          .image = random.chance(20),
          .columns = columns,
          .rows = rows,
          .mode = static_cast<model::Mode>(random.between(0, 2)),
          .threshold = random.between(50 << more_bits, 200 << more_bits),
          .select = strongest ? model::Select::strongest : model::Select::all,
          .gap = build.runs ? random.between(0, 3) : 0,
          .stream = random.between(0, 255),
          .compact = build.compact && random.chance(40),
          .verdict = random.chance(90),
          .verdict_packets = random.between(0, 2),
          .verdict_hold = random.chance(15),
          .verdict_settings = {.width = random.between(1, 5),
                               .history = history,
                               .hits = random.between(1, history),
                               .above = random.chance(70),
                               .below = random.chance(70),
                               .most_unlit = random.chance(50) ? model::kUnlitNotJudged : random.between(0, 40),
                               .shift_columns = random.chance(50) ? 0 : random.between(-12, 12),
                               .shift_rows = random.chance(50) ? 0 : random.between(-60, 60),
                               .bank = random.between(0, 1)},
          .part_rule = {.by_encoder = random.chance(50),
                        .lit = random.between(1, 40),
                        .dark_frames = random.between(1, 2),
                        .start = (encoder + static_cast<std::uint32_t>(random.between(-20, 40))) & model::kCountMask,
                        .length = length,
                        .pitch = length + static_cast<std::uint32_t>(random.between(1, 20))}};
}

struct VerdictCounts {
  std::uint64_t frames = 0, delivered = 0, lost = 0, parts = 0, bad = 0, refused = 0;
};

// Frames of `changes` settings, each with limits and words written before it, packets lost by stalls, and faults. With
// 4 lanes frames of fewer rows than 8 may end too soon, of fewer than 17 come too soon behind one that broke; with more
// lanes those of as many times more.
template <class Model>
void play_verdicts(std::uint64_t seed, int fault_percent, int changes, VerdictCounts& seen) {
  Random random(seed);
  constexpr int kSections = 2;
  static_assert(1 << kBuild<Model>.verdict_log_sections == kSections && kBuild<Model>.max_columns >= 64);
  constexpr int kLanes = kBuild<Model>.lanes;
  constexpr int kSlower = kLanes / spec::kPixelsPerBeat;
  VerdictBoard<Model> bench(random_board_clocks(random, seed, kBuild<Model>.pixel_bits, kLanes));
  const int columns = kLanes * random.between(32 / kLanes, 64 / kLanes);
  Scoreboard<Model>& board = bench.board();
  bench.access(false, spec::kRegVerdictControl);
  EXPECT_FALSE(bench.write(spec::kRegVerdictControl, 1U << spec::kRegVerdictControlOnLsb)) << "nothing is written yet";
  bench.write(spec::kRegEjectorDelay, 0);
  bench.write(spec::kRegEjectorLength, 3);
  for (int bank = 0; bank < 2; ++bank) {
    for (int section = 0; section < kSections; ++section) {
      for (int column = 0; column < 64; ++column) {
        bench.write_limits(bank, section, column, random_limits(random, kBuild<Model>, 8));
      }
      bench.begin_section(bank, section, static_cast<std::uint32_t>(random.between(0, 30)));
    }
  }
  board.turn_encoder(random.between(4, 200));
  int rows = 0;  // in force: of the last frame
  for (int change = 0; change < changes && !::testing::Test::HasFailure(); ++change) {
    board.device().drain(kApart);
    model::BoardSettings settings =
        random_settings(random, kBuild<Model>, columns, board.device().read(spec::kRegEncoder),
                        kSlower * (fault_percent == 0 ? 8 : 17));
    // What `hold` keeps is the size of frames too, but not what belongs to verdicts.
    settings.hold = settings.hold && rows > 0;
    settings.rows = settings.hold ? rows : settings.rows;
    // Anything to any register, but for those of the pin, whose pulses the model does not know. The settings follow.
    for (int i = board.model().frame_open() ? 0 : random.between(0, 12); i > 0; --i) {
      const auto word = static_cast<std::uint32_t>(random.bits()) >> random.between(0, 31);
      const std::uint32_t address = spec::kRegVerdictControl + 4U * static_cast<std::uint32_t>(random.between(0, 31));
      const bool of_the_pin = address == spec::kRegEjectorDelay || address == spec::kRegEjectorLength;
      bench.access(random.chance(50) && !of_the_pin, address, word);
    }
    bench.write(settings);
    // While a frame is open the board knows its part already, the model does not.
    if (!board.model().frame_open()) {
      for (int i = random.between(0, 6); i > 0; --i) {
        const int bank = random.between(0, 1);
        seen.refused += bench.write_limits(bank, random.between(0, 1), random.between(0, 63),
                                           random_limits(random, kBuild<Model>, settings.rows))
                            ? 0
                            : 1;
        seen.refused += bench.begin_section(bank, 1, static_cast<std::uint32_t>(random.between(0, 30))) ? 0 : 1;
      }
      bench.access(false, spec::kRegVerdictState);
      bench.access(false, spec::kRegVerdictParts);
      bench.access(false, spec::kRegVerdictLimits);
      bench.access(false, spec::kRegVerdictDefect);
    }
    board.device().set_video_gap_percent(random.chance(40) ? 0 : random.between(0, 60));
    const bool stalls = random.chance(20);  // until packets are lost
    board.device().set_bus_stall_percent(stalls ? 99 : random.chance(60) ? 0 : random.between(0, 90));
    const int dark = random.chance(50) ? 0 : 40;
    for (int i = stalls ? 60 : random.between(-2, 12); i > 0; --i) {
      rows = settings.rows;
      const TestImage image = random.chance(dark) ? constant_image(settings.rows, settings.columns, 0)
                                                  : random_image(random, settings.rows, settings.columns);
      board.send(random, image, fault_percent);
      board.device().gap(static_cast<std::uint32_t>(kApart + random.between(0, 100)));
    }
    board.play();
    board.device().set_bus_stall_percent(0);
  }
  board.finish();
  seen.frames += board.model().frames();
  seen.delivered += board.delivered(spec::kKindMoments);
  seen.lost += board.lost(spec::kKindMoments);
  seen.parts += bench.verdict().parts();
  seen.bad += bench.verdict().bad_parts();
  if (!board.model().frame_open()) {
    bench.access(false, spec::kRegVerdictParts);
    bench.access(false, spec::kRegVerdictState);
  }
}

// From the last pixels of the frame that has the first defect to the pin.
template <class Model>
int clocks_to_the_pin(int columns, model::Mode mode) {
  constexpr int kRows = 2 * kBuild<Model>.lanes;
  VerdictBoard<Model> bench;
  bench.write(spec::kRegEjectorDelay, 0);
  bench.write(spec::kRegEjectorLength, 1);
  for (int column = 0; column < columns; ++column) {
    bench.write_limits(0, 0, column, {.low = 3 * model::kRowParts, .high = 5 * model::kRowParts, .judged = true});
  }
  if (kBuild<Model>.verdict_log_sections > 0) {
    bench.begin_section(0, 1, model::kCountMask);  // never
  }
  bench.write({.columns = columns,
               .rows = kRows,
               .mode = mode,
               .threshold = 100,
               .verdict = true,
               .verdict_packets = 1,
               .verdict_settings = {.width = 16, .history = 2, .hits = 2},
               .part_rule = {.by_encoder = true, .length = 1000, .pitch = 2000}});
  int clocks = -1;
  for (const int row : {4, 7, 7}) {  // good, the first hit, the second
    EXPECT_FALSE(bench.device().ejector());
    TestImage image = constant_image(kRows, columns, 0);
    std::fill_n(image.pixels.begin() + static_cast<std::ptrdiff_t>(row - 1) * columns, columns, std::uint8_t{200});
    bench.device().send(image.view());
    bench.board().play();
    for (clocks = 0; clocks < 300 && !bench.device().ejector(); ++clocks) {
      bench.device().run(1);
    }
  }
  bench.board().finish();
  EXPECT_EQ(bench.verdict().bad_parts(), 1U);
  return clocks;
}

// How many frames are missed, of so many without a pause between pixels or frames.
template <class Model>
std::uint32_t missed_frames(int columns, int rows, model::Mode mode, int frames) {
  VerdictBoard<Model> bench;
  bench.write(spec::kRegEjectorDelay, 0);
  bench.write(spec::kRegEjectorLength, 1);
  bench.write(
      {.columns = columns, .rows = rows, .mode = mode, .threshold = 100, .verdict = true, .verdict_packets = 2});
  const TestImage image = constant_image(rows, columns, 200);
  for (int i = 0; i < frames; ++i) {
    bench.device().send(image.view());
  }
  bench.device().drain(1000);
  const std::uint32_t state = bench.device().read(spec::kRegVerdictState);
  return state >> spec::kRegVerdictStateMissedLsb & ((1U << spec::kRegVerdictStateMissedBits) - 1);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BOARD_VERDICT_BOARD_H
