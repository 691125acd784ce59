// The SystemC shells of the moments with their memories, for pixels of any bits and any lanes: F is a
// hls::MomentsFormats.
#ifndef SELFPROJ_SIM_BOARD_MOMENTS_BLOCKS_H
#define SELFPROJ_SIM_BOARD_MOMENTS_BLOCKS_H

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <systemc>
#include <vector>

#include "hls/shells/column_moments_shell.h"
#include "hls/shells/column_runs_shell.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/little_endian.h"
#include "sim/board/shell_block.h"

namespace selfproj::sim {

// What both circuits of the moments have.
template <typename F>
struct MomentsPins {
  std::uint8_t rst_i = 0;
  std::uint8_t beat_valid_i = 0;
  PortOf<F::kLanes * F::kPixelBits> beat_pixels_i{};
  std::uint16_t beat_group_i = 0;
  std::uint16_t beat_row_i = 0;
  std::uint8_t beat_first_row_i = 0;
  std::uint8_t beat_last_row_i = 0;
  std::uint8_t beat_line_end_i = 0;
  std::uint8_t mode_i = 0;
  PortOf<F::kPixelBits> threshold_i = 0;
  std::uint8_t break_i = 0;
  std::uint8_t accept_i = 0;

  std::uint8_t moments_valid_o = 0;
  PortOf<32 * F::kLanes> moments_data_o{};
  std::uint8_t moments_break_o = 0;
  std::uint8_t spoiled_o = 0;
};

template <typename F>
struct ColumnMomentsPinsOf : MomentsPins<F> {
  std::uint8_t one_group_i = 0;
  std::uint8_t two_groups_i = 0;
};

template <typename F>
struct ColumnRunsPinsOf : MomentsPins<F> {
  std::uint8_t strongest_i = 0;
  std::uint8_t gap_i = 0;
};

using ColumnMomentsPins = ColumnMomentsPinsOf<hls::FourOfEight>;
using ColumnRunsPins = ColumnRunsPinsOf<hls::FourOfEight>;

// The common part of both circuits of the moments: their beats and moments, and the line buffer.
template <typename F>
class MomentsBlock : public ShellBlock {
 protected:
  using Group = typename F::Group;
  using Pixels = typename F::Pixels;

  using ShellBlock::ShellBlock;

  // Connects the ports that both shells have.
  void connect_common(hls::MomentsPorts<F>& shell) {
    shell.clk_i(clk_);
    shell.rst_i(rst_);
    shell.beat_valid_i(beat_valid_);
    shell.beat_pixels_i(pixels_);
    shell.beat_group_i(group_);
    shell.beat_row_i(row_);
    shell.beat_first_row_i(first_row_);
    shell.beat_last_row_i(last_row_);
    shell.beat_line_end_i(line_end_);
    shell.mode_i(mode_);
    shell.threshold_i(threshold_);
    shell.break_i(break_);
    shell.accept_i(accept_);
    shell.moments_valid_o(valid_o_);
    shell.moments_data_o(data_o_);
    shell.moments_break_o(break_o_);
    shell.spoiled_o(spoiled_o_);
    shell.line_rd_en_o(line_rd_);
    shell.line_rd_addr_o(line_rd_at_);
    shell.line_rd_data_i(line_in_);
    shell.line_wr_en_o(line_wr_);
    shell.line_wr_addr_o(line_wr_at_);
    shell.line_wr_data_o(line_out_);
    connect(line_, clk_, line_rd_, line_rd_at_, line_in_, line_wr_, line_wr_at_, line_out_);
  }

  // Writes the inputs that both have, makes the edge, and reads the outputs.
  void pass_clock_with(MomentsPins<F>& pins) {
    beat_valid_.write(pins.beat_valid_i != 0);
    pixels_.write(number_of<Pixels>(pins.beat_pixels_i));
    group_.write(pins.beat_group_i);
    row_.write(pins.beat_row_i);
    first_row_.write(pins.beat_first_row_i != 0);
    last_row_.write(pins.beat_last_row_i != 0);
    line_end_.write(pins.beat_line_end_i != 0);
    mode_.write(pins.mode_i);
    threshold_.write(pins.threshold_i);
    break_.write(pins.break_i != 0);
    accept_.write(pins.accept_i != 0);
    pass_clock(pins.rst_i != 0);
    pins.moments_valid_o = valid_o_.read();
    if (valid_o_.read()) {
      pins.moments_data_o = port_of(data_o_.read());
    }
    pins.moments_break_o = break_o_.read();
    pins.spoiled_o = spoiled_o_.read();
  }

 private:
  ShellRam<Pixels, Group> line_{"line"};

  Signal<bool> beat_valid_{"beat_valid"}, first_row_{"first_row"}, last_row_{"last_row"}, line_end_{"line_end"};
  Signal<bool> break_{"break_in"}, accept_{"accept"};
  Signal<Pixels> pixels_{"pixels"};
  Signal<Group> group_{"group"};
  Signal<hls::Row> row_{"row"};
  Signal<hls::ModeBits> mode_{"mode"};
  Signal<typename F::Pixel> threshold_{"threshold"};
  Signal<bool> valid_o_{"valid_o"}, break_o_{"break_o"}, spoiled_o_{"spoiled_o"};
  Signal<typename F::Payload> data_o_{"data_o"};
  Signal<bool> line_rd_{"line_rd"}, line_wr_{"line_wr"};
  Signal<Group> line_rd_at_{"line_rd_at"}, line_wr_at_{"line_wr_at"};
  Signal<Pixels> line_out_{"line_out"}, line_in_{"line_in"};
};

template <typename F>
class ColumnMomentsBlockOf : public MomentsBlock<F> {
 public:
  using Format = F;
  using Pins = ColumnMomentsPinsOf<F>;

  explicit ColumnMomentsBlockOf(const sc_core::sc_module_name& name) : MomentsBlock<F>(name) {
    this->connect_common(shell_);
    shell_.one_group_i(one_);
    shell_.two_groups_i(two_);
    shell_.m_rd_en_o(m_rd_);
    shell_.m_rd_addr_o(m_rd_at_);
    shell_.m_rd_low_i(m_low_in_);
    shell_.m_rd_high_i(m_high_in_);
    shell_.m_wr_en_o(m_wr_);
    shell_.m_wr_addr_o(m_wr_at_);
    shell_.m_wr_low_o(m_low_out_);
    shell_.m_wr_high_o(m_high_out_);
    shell_.a_rd_en_o(a_rd_);
    shell_.a_rd_addr_o(a_rd_at_);
    shell_.a_rd_low_i(a_low_in_);
    shell_.a_rd_high_i(a_high_in_);
    shell_.a_wr_en_o(a_wr_);
    shell_.a_wr_addr_o(a_wr_at_);
    shell_.a_wr_low_o(a_low_out_);
    shell_.a_wr_high_o(a_high_out_);
    connect(m_low_, this->clk_, m_rd_, m_rd_at_, m_low_in_, m_wr_, m_wr_at_, m_low_out_);
    connect(m_high_, this->clk_, m_rd_, m_rd_at_, m_high_in_, m_wr_, m_wr_at_, m_high_out_);
    connect(a_low_, this->clk_, a_rd_, a_rd_at_, a_low_in_, a_wr_, a_wr_at_, a_low_out_);
    connect(a_high_, this->clk_, a_rd_, a_rd_at_, a_high_in_, a_wr_, a_wr_at_, a_high_out_);
  }

  void clock(Pins& pins) {
    one_.write(pins.one_group_i != 0);
    two_.write(pins.two_groups_i != 0);
    this->pass_clock_with(pins);
  }

 private:
  using Group = typename F::Group;
  using MWord = typename hls::MomentsWords<F>::M;
  using AWord = typename hls::MomentsWords<F>::A;
  template <typename T>
  using Signal = sc_core::sc_signal<T>;

  hls::ColumnMomentsShellOf<F> shell_{"shell"};
  ShellRam<MWord, Group> m_low_{"m_low"}, m_high_{"m_high"};
  ShellRam<AWord, Group> a_low_{"a_low"}, a_high_{"a_high"};

  Signal<bool> one_{"one"}, two_{"two"};
  Signal<bool> m_rd_{"m_rd"}, m_wr_{"m_wr"}, a_rd_{"a_rd"}, a_wr_{"a_wr"};
  Signal<Group> m_rd_at_{"m_rd_at"}, m_wr_at_{"m_wr_at"}, a_rd_at_{"a_rd_at"}, a_wr_at_{"a_wr_at"};
  Signal<MWord> m_low_out_{"m_low_out"}, m_high_out_{"m_high_out"}, m_low_in_{"m_low_in"}, m_high_in_{"m_high_in"};
  Signal<AWord> a_low_out_{"a_low_out"}, a_high_out_{"a_high_out"}, a_low_in_{"a_low_in"}, a_high_in_{"a_high_in"};
};

template <typename F>
class ColumnRunsBlockOf : public MomentsBlock<F> {
 public:
  using Format = F;
  using Pins = ColumnRunsPinsOf<F>;

  explicit ColumnRunsBlockOf(const sc_core::sc_module_name& name) : MomentsBlock<F>(name) {
    this->connect_common(shell_);
    shell_.strongest_i(strongest_);
    shell_.gap_i(gap_);
    shell_.rd_en_o(rd_);
    shell_.rd_addr_o(rd_at_);
    shell_.wr_en_o(wr_);
    shell_.wr_addr_o(wr_at_);
    shell_.open_rd_i(open_in_);
    shell_.open_wr_o(open_out_);
    shell_.best_rd_i(best_in_);
    shell_.best_wr_o(best_out_);
    shell_.rest_rd_i(rest_in_);
    shell_.rest_wr_o(rest_out_);
    connect(open_, this->clk_, rd_, rd_at_, open_in_, wr_, wr_at_, open_out_);
    connect(best_, this->clk_, rd_, rd_at_, best_in_, wr_, wr_at_, best_out_);
    connect(rest_, this->clk_, rd_, rd_at_, rest_in_, wr_, wr_at_, rest_out_);
  }

  void clock(Pins& pins) {
    strongest_.write(pins.strongest_i != 0);
    gap_.write(pins.gap_i);
    this->pass_clock_with(pins);
  }

 private:
  using Group = typename F::Group;
  using OpenWords = typename hls::RunsWords<F>::Open;
  using BestWords = typename hls::RunsWords<F>::Best;
  using RestWords = typename hls::RunsWords<F>::Rest;
  template <typename T>
  using Signal = sc_core::sc_signal<T>;

  hls::ColumnRunsShellOf<F> shell_{"shell"};
  ShellRam<OpenWords, Group> open_{"open"};
  ShellRam<BestWords, Group> best_{"best"};
  ShellRam<RestWords, Group> rest_{"rest"};

  Signal<bool> strongest_{"strongest"};
  Signal<hls::Uint<2>> gap_{"gap"};
  Signal<bool> rd_{"rd"}, wr_{"wr"};
  Signal<Group> rd_at_{"rd_at"}, wr_at_{"wr_at"};
  Signal<OpenWords> open_in_{"open_in"}, open_out_{"open_out"};
  Signal<BestWords> best_in_{"best_in"}, best_out_{"best_out"};
  Signal<RestWords> rest_in_{"rest_in"}, rest_out_{"rest_out"};
};

using ColumnMomentsBlock = ColumnMomentsBlockOf<hls::FourOfEight>;
using ColumnRunsBlock = ColumnRunsBlockOf<hls::FourOfEight>;

// The pixels of a beat, the leftmost lowest.
template <typename F, typename Pixel>
PortOf<F::kLanes * F::kPixelBits> pixels_of(const Pixel* pixels) {
  constexpr int kBits = F::kLanes * F::kPixelBits;
  if constexpr (kBits <= 64) {
    std::uint64_t all = 0;
    for (int lane = 0; lane < F::kLanes; ++lane) {
      all |= std::uint64_t{pixels[lane]} << (lane * F::kPixelBits);
    }
    return static_cast<PortOf<kBits>>(all);
  } else {
    PortOf<kBits> port{};
    for (int lane = 0; lane < F::kLanes; ++lane) {
      const auto bit = static_cast<std::size_t>(lane * F::kPixelBits);
      const std::uint64_t moved = std::uint64_t{pixels[lane]} << bit % 32;
      port[bit / 32] |= static_cast<std::uint32_t>(moved);
      if (moved >> 32U != 0) {
        port[bit / 32 + 1] |= static_cast<std::uint32_t>(moved >> 32U);
      }
    }
    return port;
  }
}

// Gives a block of the moments the beats of a frame as the board does, with their places, and returns the payload of
// its columns. `pins` are those that only this kind of block has. Throws std::invalid_argument unless its columns are a
// multiple of the lanes, up to spec::kMaxColumns; threshold and pixels must have the format's bits.
template <typename Block, typename Pixel>
std::vector<std::uint8_t> payload_of(Block& block, typename Block::Pins pins, const model::PixelView<Pixel>& frame,
                                     const model::Measure& measure) {
  using Format = typename Block::Format;
  if (frame.columns % Format::kLanes != 0 || frame.columns > spec::kMaxColumns) {
    throw std::invalid_argument("shells: columns are no multiple of the lanes, or too many");
  }
  std::vector<std::uint8_t> bytes;
  const auto tick = [&] {
    block.clock(pins);
    if (pins.moments_valid_o != 0) {
      for (const std::uint32_t word : pins.moments_data_o) {
        bytes.resize(bytes.size() + sizeof word);
        model::store_little_endian(bytes.data() + bytes.size() - sizeof word, word);
      }
    }
  };
  reset_shell(block, pins);
  pins.accept_i = 1;
  pins.mode_i = static_cast<std::uint8_t>(measure.mode);
  pins.beat_valid_i = 1;
  for (int row = 1; row <= frame.rows; ++row) {
    const Pixel* line = frame.pixels + (row - 1) * frame.stride;
    pins.beat_row_i = static_cast<std::uint16_t>(row);
    pins.beat_first_row_i = row == 1;
    pins.beat_last_row_i = row == frame.rows;
    pins.threshold_i = static_cast<decltype(pins.threshold_i)>(
        measure.window.counts(row) ? measure.threshold : (1 << Format::kPixelBits) - 1);
    for (int column = 0; column < frame.columns; column += Format::kLanes) {
      pins.beat_pixels_i = pixels_of<Format>(line + column);
      pins.beat_group_i = static_cast<std::uint16_t>(column / Format::kLanes);
      pins.beat_line_end_i = column + Format::kLanes == frame.columns;
      tick();
    }
  }
  pins.beat_valid_i = 0;
  for (int i = 0; i < frame.columns / 2 + kShellRegisters; ++i) {  // two columns in a clock or more
    tick();
  }
  return bytes;
}

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_MOMENTS_BLOCKS_H
