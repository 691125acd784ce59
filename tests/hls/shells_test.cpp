// Compares the SystemC shells with the RTL clock by clock: with the same inputs every output must be equal. The benches
// of the RTL also compare them with the model.
#include <gtest/gtest.h>

#include <cstdint>

#include "Vsp_column_moments_ports.h"
#include "Vsp_column_runs_ports.h"
#include "Vsp_gray_decoder_ports.h"
#include "Vsp_median3x3_ports.h"
#include "Vsp_verdict_whole_ports.h"
#include "sim/board/moments_blocks.h"
#include "sim/board/shell_blocks.h"
#include "tests/hls/beside.h"
#include "tests/rtl/blocks/gray_bench.h"
#include "tests/rtl/blocks/median3x3_bench.h"
#include "tests/rtl/blocks/verdict_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// All modules must exist before the kernel first runs. One case after another uses them, and each begins with a reset,
// whatever the previous one left behind.
struct Shells {
  sim::ColumnMomentsBlock moments{"moments"};
  sim::ColumnRunsBlock runs{"runs"};
  sim::GrayDecoderBlock decoder{"decoder"};
  sim::Median3x3Block median{"median"};
  sim::VerdictBlock verdict{"verdict"};
};

Shells& shells() {
  static Shells all;
  return all;
}

}  // namespace

template <>
sim::ColumnMomentsBlock& shell_of<sim::ColumnMomentsBlock>() {
  return shells().moments;
}
template <>
sim::ColumnRunsBlock& shell_of<sim::ColumnRunsBlock>() {
  return shells().runs;
}

namespace {

using Moments = MomentsBeside<sim::ColumnMomentsBlock, Vsp_column_moments>;
using StrongestRuns = MomentsBeside<sim::ColumnRunsBlock, Vsp_column_runs>;

class Decoder final : public Beside<sim::GrayDecoderPins, Vsp_gray_decoder, Decoder> {
 public:
  using Beside::Beside;
  static sim::GrayDecoderBlock& block() { return shells().decoder; }
  void inputs(Vsp_gray_decoder& rtl) const {
    set(rtl.rst_i, rst_i);
    set(rtl.take_i, take_i);
    set(rtl.decode_i, decode_i);
    set(rtl.bits_i, bits_i);
    set(rtl.threshold_i, threshold_i);
    set(rtl.columns_i, columns_i);
    set(rtl.rows_i, rows_i);
    set(rtl.beat_valid_i, beat_valid_i);
    set(rtl.beat_pixels_i, beat_pixels_i);
    set(rtl.beat_line_start_i, beat_line_start_i);
    set(rtl.beat_line_end_i, beat_line_end_i);
    set(rtl.beat_last_row_i, beat_last_row_i);
    set(rtl.frame_start_i, frame_start_i);
    set(rtl.break_i, break_i);
    set(rtl.break_status_i, break_status_i);
    set(rtl.pattern_i, pattern_i);
    set(rtl.mem_data_i, mem_data_i);
    set(rtl.mem_late_i, mem_late_i);
    set(rtl.busy_i, busy_i);
  }
  void compare(Vsp_gray_decoder& rtl) const {
    EXPECT_EQ(mem_read_o, rtl.mem_read_o);
    if (rtl.mem_read_o != 0) {
      EXPECT_EQ(mem_read_first_o, rtl.mem_read_first_o);
    }
    EXPECT_EQ(mem_write_o, rtl.mem_write_o);
    if (rtl.mem_write_o != 0) {
      EXPECT_EQ(mem_write_first_o, rtl.mem_write_first_o);
      EXPECT_EQ(word128(mem_data_o), word128(rtl.mem_data_o));
    }
    EXPECT_EQ(mem_end_o, rtl.mem_end_o);
    EXPECT_EQ(codes_valid_o, rtl.codes_valid_o);
    if (rtl.codes_valid_o != 0) {
      EXPECT_EQ(codes_o, rtl.codes_o);
      EXPECT_EQ(codes_start_o, rtl.codes_start_o);
      EXPECT_EQ(codes_line_start_o, rtl.codes_line_start_o);
      EXPECT_EQ(codes_line_end_o, rtl.codes_line_end_o);
      EXPECT_EQ(codes_last_row_o, rtl.codes_last_row_o);
    }
    EXPECT_EQ(codes_break_o, rtl.codes_break_o);
    if (rtl.codes_break_o != 0) {
      EXPECT_EQ(codes_status_o, rtl.codes_status_o);
    }
    EXPECT_EQ(abandoned_o, rtl.abandoned_o);
  }
};

class Median final : public Beside<sim::Median3x3Pins, Vsp_median3x3, Median> {
 public:
  using Beside::Beside;
  static sim::Median3x3Block& block() { return shells().median; }
  void inputs(Vsp_median3x3& rtl) const {
    set(rtl.rst_i, rst_i);
    set(rtl.s_valid_i, s_valid_i);
    set(rtl.s_codes_i, s_codes_i);
    set(rtl.s_start_i, s_start_i);
    set(rtl.s_line_start_i, s_line_start_i);
    set(rtl.s_line_end_i, s_line_end_i);
    set(rtl.s_last_row_i, s_last_row_i);
    set(rtl.s_break_i, s_break_i);
    set(rtl.s_status_i, s_status_i);
    set(rtl.s_median_i, s_median_i);
  }
  void compare(Vsp_median3x3& rtl) const {
    EXPECT_EQ(busy_o, rtl.busy_o);
    EXPECT_EQ(m_valid_o, rtl.m_valid_o);
    if (rtl.m_valid_o != 0) {
      EXPECT_EQ(m_codes_o, rtl.m_codes_o);
      EXPECT_EQ(m_start_o, rtl.m_start_o);
      EXPECT_EQ(m_line_start_o, rtl.m_line_start_o);
      EXPECT_EQ(m_line_end_o, rtl.m_line_end_o);
    }
    EXPECT_EQ(m_break_o, rtl.m_break_o);
    if (rtl.m_break_o != 0) {
      EXPECT_EQ(m_status_o, rtl.m_status_o);
    }
  }
};

class Judge final : public Beside<sim::VerdictPins, Vsp_verdict_whole, Judge> {
 public:
  using Beside::Beside;
  static sim::VerdictBlock& block() { return shells().verdict; }
  void inputs(Vsp_verdict_whole& rtl) const {
    set(rtl.rst_i, rst_i);
    set(rtl.write_i, write_i);
    set(rtl.write_word_i, write_word_i);
    set(rtl.write_data_i, write_data_i);
    set(rtl.hold_i, hold_i);
    set(rtl.by_encoder_i, by_encoder_i);
    set(rtl.write_limits_i, write_limits_i);
    set(rtl.write_bank_i, write_bank_i);
    set(rtl.write_section_i, write_section_i);
    set(rtl.write_column_i, write_column_i);
    set(rtl.write_limits_word_i, write_limits_word_i);
    set(rtl.frame_i, frame_i);
    set(rtl.restart_i, restart_i);
    set(rtl.encoder_i, encoder_i);
    set(rtl.groups_i, groups_i);
    set(rtl.grey_i, grey_i);
    set(rtl.beat_valid_i, beat_valid_i);
    set(rtl.beat_data_i, beat_data_i);
    set(rtl.break_i, break_i);
  }
  void compare(Vsp_verdict_whole& rtl) {
    EXPECT_EQ(start_o, rtl.start_o);
    EXPECT_EQ(ready_o, rtl.ready_o);
    EXPECT_EQ(passes_o, rtl.passes_o);
    EXPECT_EQ(section_o, rtl.section_o);
    EXPECT_EQ(part_o, rtl.part_o);
    EXPECT_EQ(bank_o, rtl.bank_o);
    started_ = started_ || rtl.start_o != 0;
    if (started_) {
      EXPECT_EQ(count_o, rtl.count_o);
      EXPECT_EQ(word_o, rtl.word_o);
    }
    EXPECT_EQ(first_bad_o, rtl.first_bad_o);
    EXPECT_EQ(verdict_valid_o, rtl.verdict_valid_o);
    if (rtl.verdict_valid_o != 0) {
      EXPECT_EQ(in_part_o, rtl.in_part_o);
      EXPECT_EQ(defect_o, rtl.defect_o);
      EXPECT_EQ(lacks_light_o, rtl.lacks_light_o);
      EXPECT_EQ(first_column_o, rtl.first_column_o);
      EXPECT_EQ(columns_o, rtl.columns_o);
      EXPECT_EQ(unlit_o, rtl.unlit_o);
    }
  }

 private:
  bool started_ = false;
};

TEST(ColumnMomentsShell, SmallSizes) { small_sizes<Moments>(); }
TEST(ColumnMomentsShell, TallestImages) { tallest_images<Moments>(); }
TEST(ColumnMomentsShell, WidestImages) { widest_images<Moments>(); }
TEST(ColumnMomentsShell, RandomFrames) { random_frames<Moments>(); }

TEST(ColumnMomentsShell, OriginalImage) {
  moments::large_size<Moments>(512, 96, kModes);
  expect_clocks(70'000);
}

TEST(ColumnRunsShell, SmallSizes) { small_sizes<StrongestRuns>(); }
TEST(ColumnRunsShell, TallestImages) { tallest_images<StrongestRuns>(); }
TEST(ColumnRunsShell, WidestImages) { widest_images<StrongestRuns>(); }
TEST(ColumnRunsShell, RandomFrames) { random_frames<StrongestRuns>(); }

TEST(GrayDecoderShell, RandomSequences) {
  std::uint64_t pixels = 0;
  for_cases(40, [&](Random& random) {
    GrayBench<Decoder> bench(random);
    bench.late_permille = random.chance(60) ? 0 : random.between(0, 10);
    bench.busy_percent = random.chance(60) ? 0 : random.between(0, 10);
    play_gray_frames(bench, {.frames = 250}, random);
    ASSERT_FALSE(HasFailure());
    pixels += bench.pixels();
  });
  if (runs_all_cases()) {
    EXPECT_GT(pixels, 30'000U) << "too little was compared";
  }
  expect_clocks(100'000);
}

TEST(Median3x3Shell, RandomImagesGapsAndBreaks) {
  median::random_images<Median>(40);
  expect_clocks(10'000);
}

TEST(VerdictShell, RandomFrames) {
  verdict::random_frames<Judge>(8, 250);
  expect_clocks(200'000);
}

}  // namespace
}  // namespace selfproj::test
