// A SystemC shell beside the RTL: with the same inputs in every clock every output must be equal. The RTL's benches
// also compare the shell with the model.
#ifndef SELFPROJ_TESTS_HLS_BESIDE_H
#define SELFPROJ_TESTS_HLS_BESIDE_H

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "sim/board/moments_blocks.h"
#include "tests/rtl/blocks/column_moments_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

template <typename To, typename From>
void set(To& to, const From& from) {
  if constexpr (std::is_integral_v<To>) {
    to = static_cast<To>(from);
  } else {
    for (std::size_t i = 0; i < from.size(); ++i) {
      to[i] = from[i];
    }
  }
}

// Clocks compared, and how many outputs differed.
inline std::uint64_t g_clocks = 0;

// A bench takes the shell for a Verilated model; the real one runs beside it.
template <typename Pins, typename Rtl, typename Derived>
class Beside : public Pins {
 public:
  explicit Beside(VerilatedContext* context) : rtl_(context) {}
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;
  ~Beside() = default;

  std::uint8_t clk_i = 0;

  void eval() {
    rtl_.clk_i = clk_i;
    static_cast<Derived*>(this)->inputs(rtl_);
    rtl_.eval();
    if (clk_i != 0 && !high_) {
      Derived::block().clock(*this);
      known_ = known_ || this->rst_i != 0;
      if (known_) {
        ++g_clocks;
        static_cast<Derived*>(this)->compare(rtl_);
      }
    }
    high_ = clk_i != 0;
  }
  void final() { rtl_.final(); }

 private:
  Rtl rtl_;
  bool high_ = false;
  bool known_ = false;  // there has been a reset
};

// The shell of this kind: a test has one of each, made before the kernel first runs.
template <typename Block>
Block& shell_of();

// A shell of moments or strongest runs beside its RTL.
template <typename Block, typename Rtl>
class MomentsBeside final : public Beside<typename Block::Pins, Rtl, MomentsBeside<Block, Rtl>> {
 public:
  using Beside<typename Block::Pins, Rtl, MomentsBeside>::Beside;
  static Block& block() { return shell_of<Block>(); }
  void inputs(Rtl& rtl) const {
    set(rtl.rst_i, this->rst_i);
    set(rtl.beat_valid_i, this->beat_valid_i);
    set(rtl.beat_pixels_i, this->beat_pixels_i);
    set(rtl.beat_group_i, this->beat_group_i);
    set(rtl.beat_row_i, this->beat_row_i);
    set(rtl.beat_first_row_i, this->beat_first_row_i);
    set(rtl.beat_last_row_i, this->beat_last_row_i);
    set(rtl.beat_line_end_i, this->beat_line_end_i);
    set(rtl.mode_i, this->mode_i);
    set(rtl.threshold_i, this->threshold_i);
    set(rtl.break_i, this->break_i);
    set(rtl.accept_i, this->accept_i);
    if constexpr (moments::kRuns<Rtl>) {
      set(rtl.strongest_i, this->strongest_i);
      set(rtl.gap_i, this->gap_i);
    } else {
      set(rtl.one_group_i, this->one_group_i);
      set(rtl.two_groups_i, this->two_groups_i);
    }
  }
  void compare(Rtl& rtl) const {
    EXPECT_EQ(this->moments_valid_o, rtl.moments_valid_o);
    if (rtl.moments_valid_o != 0) {
      for (std::size_t i = 0; i < this->moments_data_o.size(); ++i) {
        EXPECT_EQ(this->moments_data_o[i], rtl.moments_data_o[i]);
      }
    }
    EXPECT_EQ(this->moments_break_o, rtl.moments_break_o);
    EXPECT_EQ(this->spoiled_o, rtl.spoiled_o);
  }
};

template <typename Block, typename Rtl>
inline constexpr int moments::kPixelBits<MomentsBeside<Block, Rtl>> = Block::Format::kPixelBits;
template <typename Block, typename Rtl>
inline constexpr int moments::kLanes<MomentsBeside<Block, Rtl>> = Block::Format::kLanes;
// A grey build with the strongest runs, as in column_runs_test.cpp.
template <typename Block, typename Rtl>
inline constexpr bool moments::kBinaryDrains<MomentsBeside<Block, Rtl>> = moments::kRuns<Rtl>;

template <typename Dut>
void list_ports(const Dut& /*dut*/, const Recorder& /*recorder*/) {}  // records nothing of them

inline void expect_clocks(std::uint64_t min) {
  if (runs_all_cases()) {
    EXPECT_GT(std::exchange(g_clocks, 0U), min) << "too little was compared";
  }
}

template <typename Circuit>
void small_sizes() {
  moments::small_sizes<Circuit>(kModes);
  expect_clocks(30'000 * 4 / moments::kLanes<Circuit>);
}

// 255 in every pixel of the tallest image: every sum at its largest, one and two groups a line.
template <typename Circuit>
void tallest_images() {
  for (const int columns : {moments::kLanes<Circuit>, 2 * moments::kLanes<Circuit>}) {
    moments::large_size<Circuit>(columns, 1023, kModes);
  }
  expect_clocks(15'000);
}

// The widest image, with as many rows as it takes for its packet to leave before the next one.
template <typename Circuit>
void widest_images() {
  moments::large_size<Circuit>(spec::kMaxColumns, moments::kLanes<Circuit>, kModes);
  expect_clocks(12'000);
}

template <typename Circuit>
void random_frames() {
  for_cases(60, [&](std::uint64_t seed) {
    Random one_size(seed);
    moments::random_frames<Circuit>(one_size, kModes, 64, 9, false);
    Random changing(seed);
    moments::random_frames<Circuit>(changing, kModes, changing.chance(50) ? 64 : 400, 9, true);
  });
  expect_clocks(200'000 * 4 / moments::kLanes<Circuit>);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HLS_BESIDE_H
