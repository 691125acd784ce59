// The 3 x 3 median of codes as a SystemC module with the ports of rtl/gray/sp_median3x3.sv, for compilers that
// translate clocked threads.
//
// With the same inputs in every clock the outputs equal those of the RTL in every clock: one beat a clock, no bubble.
// The tests compare both clock by clock. The median itself is median_of() of hls/median_arithmetic.h. This file decides
// when it is taken. The registers have the names of the RTL's. Unlike there, a median is found in one clock and then
// passes two registers, which a synthesizer may move into it. The line buffers are outside, behind ports. Each has one
// port that writes and one that reads a clock later, like sp_ram.
#ifndef SELFPROJ_HLS_SHELLS_MEDIAN3X3_SHELL_H
#define SELFPROJ_HLS_SHELLS_MEDIAN3X3_SHELL_H

#include <systemc>

#include "hls/median_arithmetic.h"

namespace selfproj {
namespace hls {

constexpr int kCodeBits = spec::kCodeCodeBits + 1;
using CodeLine = Uint<kCodeLanes * kCodeBits>;  // four codes, leftmost in the low bits
using CodeGroup = Uint<bits_for(spec::kMaxColumns / kCodeLanes - 1)>;
using CodeStatus = Uint<5>;

class Median3x3Shell : public sc_core::sc_module {
 public:
  sc_core::sc_in<bool> clk_i{"clk_i"};
  sc_core::sc_in<bool> rst_i{"rst_i"};

  // Codes of the decoder
  sc_core::sc_in<bool> s_valid_i{"s_valid_i"};
  sc_core::sc_in<Uint<64>> s_codes_i{"s_codes_i"};
  sc_core::sc_in<bool> s_start_i{"s_start_i"};
  sc_core::sc_in<bool> s_line_start_i{"s_line_start_i"};
  sc_core::sc_in<bool> s_line_end_i{"s_line_end_i"};
  sc_core::sc_in<bool> s_last_row_i{"s_last_row_i"};
  sc_core::sc_in<bool> s_break_i{"s_break_i"};
  sc_core::sc_in<CodeStatus> s_status_i{"s_status_i"};
  sc_core::sc_in<bool> s_median_i{"s_median_i"};
  sc_core::sc_out<bool> busy_o{"busy_o"};

  // Codes
  sc_core::sc_out<bool> m_valid_o{"m_valid_o"};
  sc_core::sc_out<Uint<64>> m_codes_o{"m_codes_o"};
  sc_core::sc_out<bool> m_start_o{"m_start_o"};
  sc_core::sc_out<bool> m_line_start_o{"m_line_start_o"};
  sc_core::sc_out<bool> m_line_end_o{"m_line_end_o"};
  sc_core::sc_out<bool> m_break_o{"m_break_o"};
  sc_core::sc_out<CodeStatus> m_status_o{"m_status_o"};

  // Line buffers: near holds the previous line, far the one before it. Both are read at once.
  sc_core::sc_out<bool> rd_en_o{"rd_en_o"};
  sc_core::sc_out<CodeGroup> rd_addr_o{"rd_addr_o"};
  sc_core::sc_in<CodeLine> near_rd_data_i{"near_rd_data_i"};
  sc_core::sc_in<CodeLine> far_rd_data_i{"far_rd_data_i"};
  sc_core::sc_out<CodeGroup> wr_addr_o{"wr_addr_o"};
  sc_core::sc_out<bool> near_wr_en_o{"near_wr_en_o"};
  sc_core::sc_out<CodeLine> near_wr_data_o{"near_wr_data_o"};
  sc_core::sc_out<bool> far_wr_en_o{"far_wr_en_o"};
  sc_core::sc_out<CodeLine> far_wr_data_o{"far_wr_data_o"};

  SC_HAS_PROCESS(Median3x3Shell);
  explicit Median3x3Shell(const sc_core::sc_module_name& name) : sc_module(name) {
    SC_CTHREAD(clocked, clk_i.pos());
    reset_signal_is(rst_i, true);
    SC_METHOD(read_lines);
    sensitive << s_valid_i << s_start_i << s_line_start_i << passing_ << lines_ << group_ << pass_group_;
    SC_METHOD(write_far);
    sensitive << same1_ << near_written_ << near_rd_data_i;
  }

 private:
  // Registers that a memory port follows in the same clock
  sc_core::sc_signal<bool> passing_{"passing"};   // the frame's last line leaves
  sc_core::sc_signal<Uint<2>> lines_{"lines"};    // complete lines of the frame, up to 2
  sc_core::sc_signal<CodeGroup> group_{"group"};  // the next one's
  sc_core::sc_signal<CodeGroup> pass_group_{"pass_group"};
  sc_core::sc_signal<bool> same1_{"same1"};  // the read was in the clock of the write: what is written counts
  sc_core::sc_signal<CodeLine> near_written_{"near_written"};

  void read_lines() {
    bool step = passing_.read();
    if (s_valid_i.read() && !s_start_i.read() && lines_.read() != 0) {
      step = true;
    }
    CodeGroup group = group_.read();
    if (passing_.read()) {
      group = pass_group_.read();
    } else if (s_line_start_i.read()) {
      group = 0;
    }
    rd_en_o.write(step);
    rd_addr_o.write(group);
  }

  void write_far() {
    CodeLine line = near_rd_data_i.read();
    if (same1_.read()) {
      line = near_written_.read();
    }
    far_wr_data_o.write(line);
  }

  // --- Registers ---
  bool open_, busy_, median_;
  CodeGroup last_group_;
  // Stage 1
  CodeLine now1_, far_written_;
  bool valid1_, step1_, first1_, last1_, top1_, bottom1_;
  CodeGroup group1_;
  // The previous step, and the window
  Code middle_[kCodeLanes][3];
  Code left_[3];
  bool middle_valid_, middle_first_, middle_last_, middle_top_, middle_bottom_;
  Code window_[kCodeLanes + 2][3];
  bool window_valid_, window_first_, window_last_, window_top_, window_bottom_;
  // Medians, and what accompanies them
  Uint<64> codes_[3];
  bool valid_[3];
  bool start_[3];
  bool first_[3];
  bool last_[3];
  bool break_[6];
  CodeStatus status_[6];

  void reset() {
    passing_.write(false);
    lines_.write(0);
    group_.write(0);
    pass_group_.write(0);
    same1_.write(false);
    near_written_.write(0);
    open_ = false;
    busy_ = false;
    median_ = false;
    last_group_ = 0;
    now1_ = 0;
    far_written_ = 0;
    valid1_ = false;
    step1_ = false;
    first1_ = false;
    last1_ = false;
    top1_ = false;
    bottom1_ = false;
    group1_ = 0;
    middle_valid_ = false;
    middle_first_ = false;
    middle_last_ = false;
    middle_top_ = false;
    middle_bottom_ = false;
    window_valid_ = false;
    window_first_ = false;
    window_last_ = false;
    window_top_ = false;
    window_bottom_ = false;
    for (int row = 0; row < 3; ++row) {
      left_[row] = 0;
      for (int lane = 0; lane < kCodeLanes; ++lane) {
        middle_[lane][row] = 0;
      }
      for (int lane = 0; lane < kCodeLanes + 2; ++lane) {
        window_[lane][row] = 0;
      }
      codes_[row] = 0;
      valid_[row] = false;
      start_[row] = false;
      first_[row] = false;
      last_[row] = false;
    }
    for (int i = 0; i < 6; ++i) {
      break_[i] = false;
      status_[i] = 0;
    }
  }

  void clocked() {
    reset();
    show_reset();
    wait();
    while (true) {
      // From the exit to the entry, so that each step sees the registers before it as they were in the clock that ends.
      medians();
      window();
      enter();
      show();
      wait();
    }
  }

  void medians() {
    for (int i = 2; i > 0; --i) {
      codes_[i] = codes_[i - 1];
      valid_[i] = valid_[i - 1];
      start_[i] = start_[i - 1];
      first_[i] = first_[i - 1];
      last_[i] = last_[i - 1];
    }
    codes_[0] = 0;
    for (int lane = kCodeLanes - 1; lane >= 0; --lane) {
      Code nine[9];
      for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row) {
          nine[3 * column + row] = window_[lane + column][row];
        }
      }
      const bool outer = (lane == 0 && window_first_) || (lane == kCodeLanes - 1 && window_last_);
      Uint<4> half = half_of(window_top_, window_bottom_, outer);
      Code code = nine[4];
      if (median_) {
        code = median_of(nine, half);
      }
      CodeWord word = word_of(code);
      codes_[0] = (codes_[0] << spec::kCodeWordBits) | word;
    }
    valid_[0] = window_valid_;
    start_[0] = window_valid_ && window_first_ && !window_top_;
    first_[0] = window_first_;
    last_[0] = window_last_;
  }

  void window() {
    CodeLine near = near_rd_data_i.read();
    CodeLine far = far_rd_data_i.read();
    if (same1_.read()) {
      near = near_written_.read();
      far = far_written_;
    }
    window_valid_ = middle_valid_ && (middle_last_ || (step1_ && !first1_));
    window_first_ = middle_first_;
    window_last_ = middle_last_;
    window_top_ = middle_top_;
    window_bottom_ = middle_bottom_;
    for (int row = 0; row < 3; ++row) {
      window_[0][row] = left_[row];
      window_[kCodeLanes + 1][row] = 0;
    }
    const Code last_left0 = middle_[kCodeLanes - 1][0];
    const Code last_left1 = middle_[kCodeLanes - 1][1];
    const Code last_left2 = middle_[kCodeLanes - 1][2];
    for (int lane = 0; lane < kCodeLanes; ++lane) {
      Code above = far >> (kCodeBits * lane);
      const Code centre = near >> (kCodeBits * lane);
      Code below = now1_ >> (kCodeBits * lane);
      if (!top1_) {
        above = 0;
      }
      if (!bottom1_) {
        below = 0;
      }
      for (int row = 0; row < 3; ++row) {
        window_[lane + 1][row] = middle_[lane][row];
      }
      if (lane == 0 && !middle_last_) {
        window_[kCodeLanes + 1][0] = above;
        window_[kCodeLanes + 1][1] = centre;
        window_[kCodeLanes + 1][2] = below;
      }
      if (step1_) {
        middle_[lane][0] = above;
        middle_[lane][1] = centre;
        middle_[lane][2] = below;
      }
    }
    if (step1_) {
      left_[0] = last_left0;
      left_[1] = last_left1;
      left_[2] = last_left2;
      if (first1_) {
        left_[0] = 0;
        left_[1] = 0;
        left_[2] = 0;
      }
      middle_first_ = first1_;
      middle_last_ = last1_;
      middle_top_ = top1_;
      middle_bottom_ = bottom1_;
      middle_valid_ = true;
    } else if (window_valid_) {
      middle_valid_ = false;
    }
    near_written_.write(now1_);
    far_written_ = near;
  }

  void enter() {
    const bool valid = s_valid_i.read();
    const bool line_end = s_line_end_i.read();
    const bool passing = passing_.read();
    const CodeGroup pass_group = pass_group_.read();
    Uint<2> lines = lines_.read();
    if (s_start_i.read()) {
      lines = 0;
    }
    CodeGroup group = group_.read();
    if (s_line_start_i.read()) {
      group = 0;
    }
    CodeGroup step_group = group;
    if (passing) {
      step_group = pass_group;
    }
    bool ends = valid && line_end && s_last_row_i.read();
    const bool pass_ends = pass_group == last_group_;
    bool broken = s_break_i.read() && open_;

    for (int i = 5; i > 0; --i) {
      break_[i] = break_[i - 1];
      status_[i] = status_[i - 1];
    }
    break_[0] = broken;
    status_[0] = s_status_i.read();

    same1_.write(valid1_ && group1_ == step_group);
    valid1_ = valid;
    step1_ = (valid && lines != 0) || passing;
    first1_ = step_group == 0;
    last1_ = line_end;
    top1_ = lines == 2;
    bottom1_ = !passing;
    if (passing) {
      last1_ = pass_ends;
      top1_ = lines_.read() == 2;
    }
    group1_ = group;
    const Uint<64> words = s_codes_i.read();
    now1_ = 0;
    for (int lane = kCodeLanes - 1; lane >= 0; --lane) {
      CodeWord word = words >> (spec::kCodeWordBits * lane);
      Code code = code_of(word);
      now1_ = (now1_ << kCodeBits) | code;
    }

    count(group, lines, ends, broken);
  }

  // The place in the image after this clock: `group` and `lines` belong to the beat, which `ends` the image; or the
  // image is `broken`.
  void count(const CodeGroup& group, const Uint<2>& lines, bool ends, bool broken) {
    const bool valid = s_valid_i.read();
    const bool line_end = s_line_end_i.read();
    const bool passing = passing_.read();
    const CodeGroup pass_group = pass_group_.read();
    const bool pass_ends = pass_group == last_group_;
    if (ends) {
      passing_.write(true);
    } else if (pass_ends) {
      passing_.write(false);
    }
    if (valid) {
      busy_ = true;
    } else if (broken || (passing && pass_ends)) {
      busy_ = false;
    }
    if (valid) {
      open_ = !ends;
    } else if (s_break_i.read()) {
      open_ = false;
    }
    CodeGroup next_pass_group = 0;
    if (passing) {
      next_pass_group = pass_group + 1;
    }
    pass_group_.write(next_pass_group);
    if (valid) {
      CodeGroup next_group = group + 1;
      Uint<2> next_lines = lines;
      if (line_end && lines != 2) {
        next_lines = lines + 1;
      }
      group_.write(next_group);
      lines_.write(next_lines);
      if (line_end) {
        last_group_ = group;
      }
      if (s_start_i.read()) {
        median_ = s_median_i.read();
      }
    }
  }

  // The outputs of a reset: what show() would give, as constants, because ICSC lets it see the registers as they were
  // before the reset.
  void show_reset() {
    busy_o.write(false);
    m_valid_o.write(false);
    m_codes_o.write(0);
    m_start_o.write(false);
    m_line_start_o.write(false);
    m_line_end_o.write(false);
    m_break_o.write(false);
    m_status_o.write(0);
    wr_addr_o.write(0);
    near_wr_en_o.write(false);
    near_wr_data_o.write(0);
    far_wr_en_o.write(false);
  }

  // The outputs of the clock that begins.
  void show() {
    near_wr_en_o.write(valid1_);
    near_wr_data_o.write(now1_);
    far_wr_en_o.write(valid1_ && step1_);
    wr_addr_o.write(group1_);
    busy_o.write(busy_);
    m_valid_o.write(valid_[2]);
    m_codes_o.write(codes_[2]);
    m_start_o.write(start_[2]);
    m_line_start_o.write(first_[2]);
    m_line_end_o.write(last_[2]);
    m_break_o.write(break_[5]);
    m_status_o.write(status_[5]);
  }
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_MEDIAN3X3_SHELL_H
