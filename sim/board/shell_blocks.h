// The SystemC shells of the Gray-code decoder, its median and the verdict, with their memories.
#ifndef SELFPROJ_SIM_BOARD_SHELL_BLOCKS_H
#define SELFPROJ_SIM_BOARD_SHELL_BLOCKS_H

#include <cstdint>
#include <systemc>

#include "hls/shells/gray_decoder_shell.h"
#include "hls/shells/median3x3_shell.h"
#include "hls/shells/verdict_shell.h"
#include "sim/board/shell_block.h"

namespace selfproj::sim {

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
  hls::Median3x3Shell shell_{"shell"};
  ShellRam<hls::CodeLine, hls::CodeGroup> near_{"near"}, far_{"far"};

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
  hls::VerdictShell shell_{"shell"};
  ShellRam<hls::VerdictWord, hls::VerdictPlace> words_{"words"};
  ShellRam<hls::LimitsWord, hls::TablePlace> table_{"table"};
  sc_core::sc_vector<ShellRam<hls::LimitsWord, hls::Group>> limits_{"limits", hls::kLanes};
  ShellRam<hls::PastWord, hls::Group> past_{"past"};

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
