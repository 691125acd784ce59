#include "sim/board/shell_blocks.h"

#include <cstddef>

namespace selfproj::sim {
// A change of a signal wakes threads and methods in the next delta cycle. Those on which others wait write in that
// cycle, so three cycles are enough. Outside of threads SystemC warns of cycles in which nothing happens.
void ShellBlock::settle() {
  constexpr int kDeltas = 3;
  if (sc_core::sc_get_current_process_handle().valid()) {
    for (int i = 0; i < kDeltas; ++i) {
      sc_core::wait(sc_core::SC_ZERO_TIME);
    }
    return;
  }
  while (sc_core::sc_pending_activity_at_current_time()) {
    sc_core::sc_start(sc_core::SC_ZERO_TIME);
  }
}

void ShellBlock::pass_clock(bool reset) {
  rst_.write(reset);
  clk_.write(false);
  settle();
  clk_.write(true);
  settle();
}

GrayDecoderBlock::GrayDecoderBlock(const sc_core::sc_module_name& name) : ShellBlock(name) {
  shell_.clk_i(clk_);
  shell_.rst_i(rst_);
  shell_.take_i(take_);
  shell_.decode_i(decode_);
  shell_.bits_i(bits_);
  shell_.threshold_i(threshold_);
  shell_.columns_i(columns_);
  shell_.rows_i(rows_);
  shell_.beat_valid_i(valid_);
  shell_.beat_pixels_i(pixels_);
  shell_.beat_line_start_i(line_start_);
  shell_.beat_line_end_i(line_end_);
  shell_.beat_last_row_i(last_row_);
  shell_.frame_start_i(start_);
  shell_.break_i(break_);
  shell_.break_status_i(status_);
  shell_.pattern_i(pattern_);
  shell_.mem_read_o(read_);
  shell_.mem_read_first_o(read_first_);
  shell_.mem_data_i(data_);
  shell_.mem_late_i(late_);
  shell_.mem_write_o(write_);
  shell_.mem_write_first_o(write_first_);
  shell_.mem_data_o(data_o_);
  shell_.mem_end_o(end_);
  shell_.busy_i(busy_);
  shell_.codes_valid_o(codes_valid_);
  shell_.codes_o(codes_);
  shell_.codes_start_o(codes_start_);
  shell_.codes_line_start_o(codes_line_start_);
  shell_.codes_line_end_o(codes_line_end_);
  shell_.codes_last_row_o(codes_last_row_);
  shell_.codes_break_o(codes_break_);
  shell_.codes_status_o(status_o_);
  shell_.abandoned_o(abandoned_);
}

void GrayDecoderBlock::clock(GrayDecoderPins& pins) {
  take_.write(pins.take_i != 0);
  decode_.write(pins.decode_i != 0);
  bits_.write(pins.bits_i);
  threshold_.write(pins.threshold_i);
  columns_.write(pins.columns_i);
  rows_.write(pins.rows_i);
  valid_.write(pins.beat_valid_i != 0);
  pixels_.write(pins.beat_pixels_i);
  line_start_.write(pins.beat_line_start_i != 0);
  line_end_.write(pins.beat_line_end_i != 0);
  last_row_.write(pins.beat_last_row_i != 0);
  start_.write(pins.frame_start_i != 0);
  break_.write(pins.break_i != 0);
  status_.write(pins.break_status_i);
  pattern_.write(pins.pattern_i);
  data_.write(number_of<hls::WideUint<128>>(pins.mem_data_i));
  late_.write(pins.mem_late_i != 0);
  busy_.write(pins.busy_i != 0);
  pass_clock(pins.rst_i != 0);
  pins.mem_read_o = read_.read();
  pins.mem_read_first_o = read_first_.read();
  pins.mem_write_o = write_.read();
  pins.mem_write_first_o = write_first_.read();
  pins.mem_data_o = port_of(data_o_.read());
  pins.mem_end_o = end_.read();
  pins.codes_valid_o = codes_valid_.read();
  pins.codes_o = codes_.read();
  pins.codes_start_o = codes_start_.read();
  pins.codes_line_start_o = codes_line_start_.read();
  pins.codes_line_end_o = codes_line_end_.read();
  pins.codes_last_row_o = codes_last_row_.read();
  pins.codes_break_o = codes_break_.read();
  pins.codes_status_o = static_cast<std::uint8_t>(status_o_.read().to_uint());
  pins.abandoned_o = abandoned_.read().to_uint();
}

Median3x3Block::Median3x3Block(const sc_core::sc_module_name& name) : ShellBlock(name) {
  shell_.clk_i(clk_);
  shell_.rst_i(rst_);
  shell_.s_valid_i(valid_);
  shell_.s_codes_i(codes_);
  shell_.s_start_i(start_);
  shell_.s_line_start_i(line_start_);
  shell_.s_line_end_i(line_end_);
  shell_.s_last_row_i(last_row_);
  shell_.s_break_i(break_);
  shell_.s_status_i(status_);
  shell_.s_median_i(median_);
  shell_.busy_o(busy_);
  shell_.m_valid_o(valid_o_);
  shell_.m_codes_o(codes_o_);
  shell_.m_start_o(start_o_);
  shell_.m_line_start_o(line_start_o_);
  shell_.m_line_end_o(line_end_o_);
  shell_.m_break_o(break_o_);
  shell_.m_status_o(status_o_);
  shell_.rd_en_o(rd_);
  shell_.rd_addr_o(rd_at_);
  shell_.near_rd_data_i(near_in_);
  shell_.far_rd_data_i(far_in_);
  shell_.wr_addr_o(wr_at_);
  shell_.near_wr_en_o(near_wr_);
  shell_.near_wr_data_o(near_out_);
  shell_.far_wr_en_o(far_wr_);
  shell_.far_wr_data_o(far_out_);
  connect(near_, clk_, rd_, rd_at_, near_in_, near_wr_, wr_at_, near_out_);
  connect(far_, clk_, rd_, rd_at_, far_in_, far_wr_, wr_at_, far_out_);
}

void Median3x3Block::clock(Median3x3Pins& pins) {
  valid_.write(pins.s_valid_i != 0);
  codes_.write(pins.s_codes_i);
  start_.write(pins.s_start_i != 0);
  line_start_.write(pins.s_line_start_i != 0);
  line_end_.write(pins.s_line_end_i != 0);
  last_row_.write(pins.s_last_row_i != 0);
  break_.write(pins.s_break_i != 0);
  status_.write(pins.s_status_i);
  median_.write(pins.s_median_i != 0);
  pass_clock(pins.rst_i != 0);
  pins.busy_o = busy_.read();
  pins.m_valid_o = valid_o_.read();
  pins.m_codes_o = codes_o_.read();
  pins.m_start_o = start_o_.read();
  pins.m_line_start_o = line_start_o_.read();
  pins.m_line_end_o = line_end_o_.read();
  pins.m_break_o = break_o_.read();
  pins.m_status_o = static_cast<std::uint8_t>(status_o_.read().to_uint());
}

VerdictBlock::VerdictBlock(const sc_core::sc_module_name& name) : ShellBlock(name) {
  shell_.clk_i(clk_);
  shell_.rst_i(rst_);
  shell_.write_i(write_);
  shell_.hold_i(hold_);
  shell_.by_encoder_i(by_encoder_);
  shell_.frame_i(frame_);
  shell_.restart_i(restart_);
  shell_.encoder_i(encoder_);
  shell_.groups_i(groups_);
  shell_.grey_i(grey_);
  shell_.start_o(start_o_);
  shell_.ready_o(ready_o_);
  shell_.beat_valid_i(valid_);
  shell_.beat_data_i(data_);
  shell_.break_i(break_);
  shell_.verdict_valid_o(verdict_valid_o_);
  shell_.in_part_o(in_part_o_);
  shell_.defect_o(defect_o_);
  shell_.lacks_light_o(lacks_light_o_);
  shell_.first_column_o(first_column_o_);
  shell_.columns_o(columns_o_);
  shell_.unlit_o(unlit_o_);
  shell_.section_o(section_o_);
  shell_.part_o(part_o_);
  shell_.count_o(count_o_);
  shell_.bank_o(bank_o_);
  shell_.first_bad_o(first_bad_o_);
  shell_.passes_o(passes_o_);
  shell_.word_o(word_o_);
  shell_.words_rd_en_o(words_rd_);
  shell_.words_rd_addr_o(words_at_);
  shell_.words_rd_data_i(words_in_);
  shell_.table_rd_addr_o(table_at_);
  shell_.table_rd_data_i(table_in_);
  shell_.limits_rd_addr_o(limits_rd_at_);
  shell_.limits_rd0_i(limits_in_[0]);
  shell_.limits_rd1_i(limits_in_[1]);
  shell_.limits_rd2_i(limits_in_[2]);
  shell_.limits_rd3_i(limits_in_[3]);
  shell_.limits_wr_en_o(limits_wr_);
  shell_.limits_wr_addr_o(limits_wr_at_);
  shell_.limits_wr_data_o(limits_out_);
  shell_.past_rd_addr_o(past_rd_at_);
  shell_.past_rd_data_i(past_in_);
  shell_.past_wr_en_o(past_wr_);
  shell_.past_wr_addr_o(past_wr_at_);
  shell_.past_wr_data_o(past_out_);
  connect(words_, clk_, words_rd_, words_at_, words_in_, write_, write_word_, write_data_);
  connect(table_, clk_, always_, table_at_, table_in_, write_limits_, write_place_, write_limits_word_);
  for (std::size_t lane = 0; lane < hls::kLanes; ++lane) {
    connect(limits_[lane], clk_, always_, limits_rd_at_, limits_in_[lane], limit_wr_[lane], limits_wr_at_, limits_out_);
  }
  connect(past_, clk_, always_, past_rd_at_, past_in_, past_wr_, past_wr_at_, past_out_);
  SC_HAS_PROCESS(VerdictBlock);
  SC_METHOD(split_lanes);
  sensitive << limits_wr_;
}

void VerdictBlock::split_lanes() {
  for (std::size_t lane = 0; lane < hls::kLanes; ++lane) {
    limit_wr_[lane].write((limits_wr_.read() >> static_cast<int>(lane) & 1) != 0);
  }
}

void VerdictBlock::clock(VerdictPins& pins) {
  write_.write(pins.write_i != 0);
  write_word_.write(pins.write_word_i);
  write_data_.write(pins.write_data_i);
  hold_.write(pins.hold_i != 0);
  by_encoder_.write(pins.by_encoder_i != 0);
  write_limits_.write(pins.write_limits_i != 0);
  write_place_.write((pins.write_bank_i * 2U + pins.write_section_i) * spec::kMaxColumns + pins.write_column_i);
  write_limits_word_.write(pins.write_limits_word_i);
  frame_.write(pins.frame_i != 0);
  restart_.write(pins.restart_i != 0);
  encoder_.write(pins.encoder_i);
  groups_.write(pins.groups_i);
  grey_.write(pins.grey_i != 0);
  valid_.write(pins.beat_valid_i != 0);
  data_.write(number_of<hls::WideUint<128>>(pins.beat_data_i));
  break_.write(pins.break_i != 0);
  pass_clock(pins.rst_i != 0);
  pins.start_o = start_o_.read();
  pins.ready_o = ready_o_.read();
  pins.verdict_valid_o = verdict_valid_o_.read();
  pins.in_part_o = in_part_o_.read();
  pins.defect_o = defect_o_.read();
  pins.lacks_light_o = lacks_light_o_.read();
  pins.first_column_o = static_cast<std::uint16_t>(first_column_o_.read().to_uint());
  pins.columns_o = static_cast<std::uint16_t>(columns_o_.read().to_uint());
  pins.unlit_o = static_cast<std::uint16_t>(unlit_o_.read().to_uint());
  pins.section_o = section_o_.read();
  pins.part_o = static_cast<std::uint16_t>(part_o_.read().to_uint());
  pins.count_o = count_o_.read().to_uint();
  pins.bank_o = bank_o_.read();
  pins.first_bad_o = first_bad_o_.read();
  pins.passes_o = passes_o_.read();
  pins.word_o = word_o_.read().to_uint();
}

}  // namespace selfproj::sim
