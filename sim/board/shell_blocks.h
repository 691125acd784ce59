// The memory beside a SystemC shell, which corresponds to rtl/common/sp_ram.sv beside a module of the RTL.
#ifndef SELFPROJ_SIM_BOARD_SHELL_BLOCKS_H
#define SELFPROJ_SIM_BOARD_SHELL_BLOCKS_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <systemc>
#include <vector>

#include "hls/shells/column_moments_shell.h"
#include "hls/shells/column_runs_shell.h"
#include "hls/shells/gray_decoder_shell.h"
#include "hls/shells/median3x3_shell.h"
#include "hls/shells/verdict_shell.h"
#include "hls/types.h"

namespace selfproj::sim {

// Words of up to 64 bits. The word at rd_addr appears at rd_data one clock after rd_en, and stays until the next read.
// A read in the same clock as a write to the same address gives a word with every bit wrong, so that nobody can rely on
// it.
template <int Bits, int AddressBits>
class ShellRam : public sc_core::sc_module {
 public:
  sc_core::sc_in<bool> clk{"clk"};
  sc_core::sc_in<bool> rd_en{"rd_en"};
  sc_core::sc_in<hls::Uint<AddressBits>> rd_addr{"rd_addr"};
  sc_core::sc_out<hls::Uint<Bits>> rd_data{"rd_data"};
  sc_core::sc_in<bool> wr_en{"wr_en"};
  sc_core::sc_in<hls::Uint<AddressBits>> wr_addr{"wr_addr"};
  sc_core::sc_in<hls::Uint<Bits>> wr_data{"wr_data"};

  explicit ShellRam(const sc_core::sc_module_name& name) : sc_module(name) {
    SC_HAS_PROCESS(ShellRam);
    SC_METHOD(access);
    sensitive << clk.pos();
    dont_initialize();
  }

 private:
  void access() {
    if (rd_en.read()) {
      std::uint64_t word = words_[rd_addr.read().to_uint()];
      if (wr_en.read() && wr_addr.read() == rd_addr.read()) {
        word = ~word;
      }
      rd_data.write(word);
    }
    if (wr_en.read()) {
      words_[wr_addr.read().to_uint()] = wr_data.read();
    }
  }

  std::vector<std::uint64_t> words_ = std::vector<std::uint64_t>(std::size_t{1} << AddressBits);
};

// The SystemC shells with their memories, stepped one clock at a time by the owner of the pins.
//
//     ColumnMomentsBlock block("moments");
//     ColumnMomentsPins pins;
//     pins.beat_valid_i = 1; ...
//     block.clock(pins);              // the edge that ends this clock; the outputs are those of the next one
//
// A block takes no simulated time: its clock is a signal that changes in delta cycles. clock() may be called from a
// thread of the block's kernel, or from outside while that kernel does not run. Like everything in SystemC, blocks must
// be built before their kernel first runs.
//
// Pins have the names of the RTL's ports and the types of a Verilated model.

using Wide128 = std::array<std::uint32_t, 4>;  // lowest word first

// What both circuits of the moments have.
struct MomentsPins {
  std::uint8_t rst_i = 0;
  std::uint8_t beat_valid_i = 0;
  std::uint32_t beat_pixels_i = 0;
  std::uint16_t beat_group_i = 0;
  std::uint16_t beat_row_i = 0;
  std::uint8_t beat_first_row_i = 0;
  std::uint8_t beat_last_row_i = 0;
  std::uint8_t beat_line_end_i = 0;
  std::uint8_t mode_i = 0;
  std::uint8_t threshold_i = 0;
  std::uint8_t break_i = 0;
  std::uint8_t accept_i = 0;

  std::uint8_t moments_valid_o = 0;
  Wide128 moments_data_o{};
  std::uint8_t moments_break_o = 0;
  std::uint8_t spoiled_o = 0;
};

struct ColumnMomentsPins : MomentsPins {
  std::uint8_t one_group_i = 0;
  std::uint8_t two_groups_i = 0;
};

struct ColumnRunsPins : MomentsPins {
  std::uint8_t strongest_i = 0;
  std::uint8_t gap_i = 0;
};

struct GrayDecoderPins {
  std::uint8_t rst_i = 0;
  std::uint8_t take_i = 0;
  std::uint8_t decode_i = 0;
  std::uint8_t bits_i = 0;
  std::uint8_t threshold_i = 0;
  std::uint16_t columns_i = 0;
  std::uint16_t rows_i = 0;
  std::uint8_t beat_valid_i = 0;
  std::uint32_t beat_pixels_i = 0;
  std::uint8_t beat_line_start_i = 0;
  std::uint8_t beat_line_end_i = 0;
  std::uint8_t beat_last_row_i = 0;
  std::uint8_t frame_start_i = 0;
  std::uint8_t break_i = 0;
  std::uint8_t break_status_i = 0;
  std::uint16_t pattern_i = 0;
  Wide128 mem_data_i{};
  std::uint8_t mem_late_i = 0;
  std::uint8_t busy_i = 0;

  std::uint8_t mem_read_o = 0;
  std::uint8_t mem_read_first_o = 0;
  std::uint8_t mem_write_o = 0;
  std::uint8_t mem_write_first_o = 0;
  Wide128 mem_data_o{};
  std::uint8_t mem_end_o = 0;
  std::uint8_t codes_valid_o = 0;
  std::uint64_t codes_o = 0;
  std::uint8_t codes_start_o = 0;
  std::uint8_t codes_line_start_o = 0;
  std::uint8_t codes_line_end_o = 0;
  std::uint8_t codes_last_row_o = 0;
  std::uint8_t codes_break_o = 0;
  std::uint8_t codes_status_o = 0;
  std::uint32_t abandoned_o = 0;
};

struct Median3x3Pins {
  std::uint8_t rst_i = 0;
  std::uint8_t s_valid_i = 0;
  std::uint64_t s_codes_i = 0;
  std::uint8_t s_start_i = 0;
  std::uint8_t s_line_start_i = 0;
  std::uint8_t s_line_end_i = 0;
  std::uint8_t s_last_row_i = 0;
  std::uint8_t s_break_i = 0;
  std::uint8_t s_status_i = 0;
  std::uint8_t s_median_i = 0;

  std::uint8_t busy_o = 0;
  std::uint8_t m_valid_o = 0;
  std::uint64_t m_codes_o = 0;
  std::uint8_t m_start_o = 0;
  std::uint8_t m_line_start_o = 0;
  std::uint8_t m_line_end_o = 0;
  std::uint8_t m_break_o = 0;
  std::uint8_t m_status_o = 0;
};

struct VerdictPins {
  std::uint8_t rst_i = 0;
  std::uint8_t write_i = 0;
  std::uint8_t write_word_i = 0;
  std::uint32_t write_data_i = 0;
  std::uint8_t hold_i = 0;
  std::uint8_t by_encoder_i = 0;
  std::uint8_t write_limits_i = 0;
  std::uint8_t write_bank_i = 0;
  std::uint8_t write_section_i = 0;
  std::uint16_t write_column_i = 0;
  std::uint64_t write_limits_word_i = 0;
  std::uint8_t frame_i = 0;
  std::uint8_t restart_i = 0;
  std::uint32_t encoder_i = 0;
  std::uint16_t groups_i = 0;
  std::uint8_t grey_i = 0;
  std::uint8_t beat_valid_i = 0;
  Wide128 beat_data_i{};
  std::uint8_t break_i = 0;

  std::uint8_t start_o = 0;
  std::uint8_t ready_o = 0;
  std::uint8_t verdict_valid_o = 0;
  std::uint8_t in_part_o = 0;
  std::uint8_t defect_o = 0;
  std::uint8_t lacks_light_o = 0;
  std::uint16_t first_column_o = 0;
  std::uint16_t columns_o = 0;
  std::uint16_t unlit_o = 0;
  std::uint8_t section_o = 0;
  std::uint16_t part_o = 0;
  std::uint32_t count_o = 0;
  std::uint8_t bank_o = 0;
  std::uint8_t first_bad_o = 0;
  std::uint8_t passes_o = 0;
  std::uint32_t word_o = 0;
};

// The common part of the blocks: clock and reset, and how a clock passes.
class ShellBlock : public sc_core::sc_module {
 public:
  using sc_core::sc_module::sc_module;

 protected:
  template <typename T>
  using Signal = sc_core::sc_signal<T>;

  // Called after the inputs were written: makes the edge, after which the outputs can be read.
  void pass_clock(bool reset);

  Signal<bool> clk_{"clk"};
  Signal<bool> rst_{"rst"};

 private:
  static void settle();
};

// The common part of both circuits of the moments: their beats and moments, and the line buffer.
class MomentsBlock : public ShellBlock {
 protected:
  using Group = hls::Group;
  static constexpr int kGroupBits = hls::bits_for(spec::kMaxColumns / hls::kLanes - 1);

  using ShellBlock::ShellBlock;

  // Connects the ports that both shells have.
  template <class Shell>
  void connect_common(Shell& shell);

  // Writes the inputs that both have, makes the edge, and reads the outputs.
  void pass_clock_with(MomentsPins& pins);

 private:
  ShellRam<32, kGroupBits> line_{"line"};

  Signal<bool> beat_valid_{"beat_valid"}, first_row_{"first_row"}, last_row_{"last_row"}, line_end_{"line_end"};
  Signal<bool> break_{"break_in"}, accept_{"accept"};
  Signal<hls::Pixels> pixels_{"pixels"};
  Signal<Group> group_{"group"};
  Signal<hls::Row> row_{"row"};
  Signal<hls::ModeBits> mode_{"mode"};
  Signal<hls::Pixel> threshold_{"threshold"};
  Signal<bool> valid_o_{"valid_o"}, break_o_{"break_o"}, spoiled_o_{"spoiled_o"};
  Signal<hls::WideUint<128>> data_o_{"data_o"};
  Signal<bool> line_rd_{"line_rd"}, line_wr_{"line_wr"};
  Signal<Group> line_rd_at_{"line_rd_at"}, line_wr_at_{"line_wr_at"};
  Signal<hls::Pixels> line_out_{"line_out"}, line_in_{"line_in"};
};

class ColumnMomentsBlock : public MomentsBlock {
 public:
  explicit ColumnMomentsBlock(const sc_core::sc_module_name& name);
  void clock(ColumnMomentsPins& pins);

 private:
  hls::ColumnMomentsShell shell_{"shell"};
  ShellRam<hls::kMBits, kGroupBits> m_low_{"m_low"}, m_high_{"m_high"};
  ShellRam<hls::kABits, kGroupBits> a_low_{"a_low"}, a_high_{"a_high"};

  Signal<bool> one_{"one"}, two_{"two"};
  Signal<bool> m_rd_{"m_rd"}, m_wr_{"m_wr"}, a_rd_{"a_rd"}, a_wr_{"a_wr"};
  Signal<Group> m_rd_at_{"m_rd_at"}, m_wr_at_{"m_wr_at"}, a_rd_at_{"a_rd_at"}, a_wr_at_{"a_wr_at"};
  Signal<hls::Uint<hls::kMBits>> m_low_out_{"m_low_out"}, m_high_out_{"m_high_out"}, m_low_in_{"m_low_in"};
  Signal<hls::Uint<hls::kMBits>> m_high_in_{"m_high_in"};
  Signal<hls::Uint<hls::kABits>> a_low_out_{"a_low_out"}, a_high_out_{"a_high_out"}, a_low_in_{"a_low_in"};
  Signal<hls::Uint<hls::kABits>> a_high_in_{"a_high_in"};
};

class ColumnRunsBlock : public MomentsBlock {
 public:
  explicit ColumnRunsBlock(const sc_core::sc_module_name& name);
  void clock(ColumnRunsPins& pins);

 private:
  // Of each lane
  template <typename T>
  using OfLanes = sc_core::sc_vector<T>;
  template <int Bits>
  using Words = OfLanes<Signal<hls::Uint<Bits>>>;

  hls::ColumnRunsShell shell_{"shell"};
  OfLanes<ShellRam<hls::kOpenBits, kGroupBits>> open_{"open", hls::kLanes};
  OfLanes<ShellRam<hls::kBestBits, kGroupBits>> best_{"best", hls::kLanes};
  OfLanes<ShellRam<hls::kRestBits, kGroupBits>> rest_{"rest", hls::kLanes};

  Signal<bool> strongest_{"strongest"};
  Signal<hls::Uint<2>> gap_{"gap"};
  Signal<bool> rd_{"rd"}, wr_{"wr"};
  Signal<Group> rd_at_{"rd_at"}, wr_at_{"wr_at"};
  Words<hls::kOpenBits> open_in_{"open_in", hls::kLanes}, open_out_{"open_out", hls::kLanes};
  Words<hls::kBestBits> best_in_{"best_in", hls::kLanes}, best_out_{"best_out", hls::kLanes};
  Words<hls::kRestBits> rest_in_{"rest_in", hls::kLanes}, rest_out_{"rest_out", hls::kLanes};
};

// The memory of the states is behind the pins.
class GrayDecoderBlock : public ShellBlock {
 public:
  explicit GrayDecoderBlock(const sc_core::sc_module_name& name);
  void clock(GrayDecoderPins& pins);

 private:
  hls::GrayDecoderShell shell_{"shell"};

  Signal<bool> take_{"take"}, decode_{"decode"}, valid_{"valid"}, line_start_{"line_start"}, line_end_{"line_end"};
  Signal<bool> last_row_{"last_row"}, start_{"start"}, break_{"break_in"}, late_{"late"}, busy_{"busy"};
  Signal<hls::PlaneCount> bits_{"bits"};
  Signal<hls::GrayPixel> threshold_{"threshold"};
  Signal<hls::Columns> columns_{"columns"};
  Signal<hls::Row> rows_{"rows"};
  Signal<hls::Pixels> pixels_{"pixels"};
  Signal<hls::Status> status_{"status"}, status_o_{"status_o"};
  Signal<hls::PatternIndex> pattern_{"pattern"};
  Signal<hls::StateWord> data_{"data"}, data_o_{"data_o"};
  Signal<bool> read_{"read"}, read_first_{"read_first"}, write_{"write"}, write_first_{"write_first"}, end_{"end"};
  Signal<bool> codes_valid_{"codes_valid"}, codes_start_{"codes_start"}, codes_line_start_{"codes_line_start"};
  Signal<bool> codes_line_end_{"codes_line_end"}, codes_last_row_{"codes_last_row"}, codes_break_{"codes_break"};
  Signal<hls::Uint<64>> codes_{"codes"};
  Signal<hls::Uint<32>> abandoned_{"abandoned"};
};

class Median3x3Block : public ShellBlock {
 public:
  explicit Median3x3Block(const sc_core::sc_module_name& name);
  void clock(Median3x3Pins& pins);

 private:
  static constexpr int kGroupBits = hls::bits_for(spec::kMaxColumns / hls::kCodeLanes - 1);
  static constexpr int kLineBits = hls::kCodeLanes * hls::kCodeBits;

  hls::Median3x3Shell shell_{"shell"};
  ShellRam<kLineBits, kGroupBits> near_{"near"}, far_{"far"};

  Signal<bool> valid_{"valid"}, start_{"start"}, line_start_{"line_start"}, line_end_{"line_end"};
  Signal<bool> last_row_{"last_row"}, break_{"break_in"}, median_{"median"}, busy_{"busy"};
  Signal<hls::Uint<64>> codes_{"codes"}, codes_o_{"codes_o"};
  Signal<hls::CodeStatus> status_{"status"}, status_o_{"status_o"};
  Signal<bool> valid_o_{"valid_o"}, start_o_{"start_o"}, line_start_o_{"line_start_o"}, line_end_o_{"line_end_o"};
  Signal<bool> break_o_{"break_o"};
  Signal<bool> rd_{"rd"}, near_wr_{"near_wr"}, far_wr_{"far_wr"};
  Signal<hls::CodeGroup> rd_at_{"rd_at"}, wr_at_{"wr_at"};
  Signal<hls::CodeLine> near_out_{"near_out"}, near_in_{"near_in"}, far_out_{"far_out"}, far_in_{"far_in"};
};

// Two sections a bank.
class VerdictBlock : public ShellBlock {
 public:
  explicit VerdictBlock(const sc_core::sc_module_name& name);
  void clock(VerdictPins& pins);

 private:
  static constexpr int kLimitsWord = 2 * hls::kLimitBits + 1;
  static constexpr int kPastBits = hls::kLanes * hls::kPastFrames;

  hls::VerdictShell shell_{"shell"};
  ShellRam<32, 5> words_{"words"};
  ShellRam<kLimitsWord, hls::kGroupIndexBits + 4> table_{"table"};
  sc_core::sc_vector<ShellRam<kLimitsWord, hls::kGroupIndexBits>> limits_{"limits", hls::kLanes};
  ShellRam<kPastBits, hls::kGroupIndexBits> past_{"past"};

  Signal<bool> always_{"always", true};
  Signal<bool> write_{"write"}, hold_{"hold"}, by_encoder_{"by_encoder"}, write_limits_{"write_limits"};
  Signal<bool> frame_{"frame"}, restart_{"restart"}, grey_{"grey"}, valid_{"valid"}, break_{"break_in"};
  Signal<hls::VerdictPlace> write_word_{"write_word"}, words_at_{"words_at"};
  Signal<hls::VerdictWord> write_data_{"write_data"}, words_in_{"words_in"}, word_o_{"word_o"};
  Signal<hls::TablePlace> write_place_{"write_place"}, table_at_{"table_at"};
  Signal<hls::LimitsWord> write_limits_word_{"write_limits_word"}, table_in_{"table_in"}, limits_out_{"limits_out"};
  Signal<hls::VerdictCount> encoder_{"encoder"}, count_o_{"count_o"};
  Signal<hls::VerdictGroups> groups_{"groups"};
  Signal<hls::WideUint<128>> data_{"data"};
  Signal<bool> start_o_{"start_o"}, ready_o_{"ready_o"}, verdict_valid_o_{"verdict_valid_o"}, in_part_o_{"in_part_o"};
  Signal<bool> defect_o_{"defect_o"}, lacks_light_o_{"lacks_light_o"}, section_o_{"section_o"}, bank_o_{"bank_o"};
  Signal<bool> first_bad_o_{"first_bad_o"}, passes_o_{"passes_o"};
  Signal<hls::VerdictColumns> first_column_o_{"first_column_o"}, columns_o_{"columns_o"}, unlit_o_{"unlit_o"};
  Signal<hls::Uint<16>> part_o_{"part_o"};
  Signal<bool> words_rd_{"words_rd"}, past_wr_{"past_wr"};
  Signal<hls::Group> limits_rd_at_{"limits_rd_at"}, limits_wr_at_{"limits_wr_at"};
  sc_core::sc_vector<Signal<hls::LimitsWord>> limits_in_{"limits_in", hls::kLanes};
  Signal<hls::Uint<hls::kLanes>> limits_wr_{"limits_wr"};
  sc_core::sc_vector<Signal<bool>> limit_wr_{"limit_wr", hls::kLanes};
  Signal<hls::Group> past_rd_at_{"past_rd_at"}, past_wr_at_{"past_wr_at"};
  Signal<hls::PastWord> past_in_{"past_in"}, past_out_{"past_out"};

  void split_lanes();
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_SHELL_BLOCKS_H
