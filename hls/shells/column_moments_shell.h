// The column moments as a SystemC module with the ports of rtl/moments/sp_column_moments.sv, for compilers that
// translate clocked threads.
//
// The promise: with the same inputs in every clock the outputs are those of the RTL in every clock, one beat a clock,
// no bubble. The tests compare both clock by clock. So the times in rtl/moments/README.md are this module's, too.
//
// What becomes of pixels, sums and words are the pure functions of hls/column_moments.h; here is when. The registers
// have the names of the RTL's. Unlike there, sums are in one piece, and a word is finished in one clock and then passes
// seven registers, for a synthesizer to move them into the additions and the multiplication; so its reads and writes of
// the memories are a clock ahead of the RTL's. The memories are outside, behind ports: each one port that writes and
// one that reads, a clock later, as sp_ram.
#ifndef SELFPROJ_HLS_SHELLS_COLUMN_MOMENTS_SHELL_H
#define SELFPROJ_HLS_SHELLS_COLUMN_MOMENTS_SHELL_H

#include <systemc>

#include "hls/column_moments.h"

namespace selfproj {
namespace hls {

constexpr int kMBits = 2 * (spec::kGreyM0Bits + spec::kGreyNBits);  // of two lanes: {N, M0}, {N, M0}
constexpr int kABits = 2 * spec::kGreyM1Bits;

class ColumnMomentsShell : public sc_core::sc_module {
 public:
  sc_core::sc_in<bool> clk_i{"clk_i"};
  sc_core::sc_in<bool> rst_i{"rst_i"};

  // A beat and where it lies, as in the RTL
  sc_core::sc_in<bool> beat_valid_i{"beat_valid_i"};
  sc_core::sc_in<Pixels> beat_pixels_i{"beat_pixels_i"};
  sc_core::sc_in<Group> beat_group_i{"beat_group_i"};
  sc_core::sc_in<Row> beat_row_i{"beat_row_i"};
  sc_core::sc_in<bool> beat_first_row_i{"beat_first_row_i"};
  sc_core::sc_in<bool> beat_last_row_i{"beat_last_row_i"};
  sc_core::sc_in<bool> beat_line_end_i{"beat_line_end_i"};
  sc_core::sc_in<bool> one_group_i{"one_group_i"};
  sc_core::sc_in<bool> two_groups_i{"two_groups_i"};
  sc_core::sc_in<ModeBits> mode_i{"mode_i"};
  sc_core::sc_in<Pixel> threshold_i{"threshold_i"};
  sc_core::sc_in<bool> break_i{"break_i"};
  sc_core::sc_in<bool> accept_i{"accept_i"};

  // Payload
  sc_core::sc_out<bool> moments_valid_o{"moments_valid_o"};
  sc_core::sc_out<WideUint<128>> moments_data_o{"moments_data_o"};
  sc_core::sc_out<bool> moments_break_o{"moments_break_o"};
  sc_core::sc_out<bool> spoiled_o{"spoiled_o"};

  // Memory of M0 and N: a word for the lanes 0 and 1, one for 2 and 3
  sc_core::sc_out<bool> m_rd_en_o{"m_rd_en_o"};
  sc_core::sc_out<Group> m_rd_addr_o{"m_rd_addr_o"};
  sc_core::sc_in<Uint<kMBits>> m_rd_low_i{"m_rd_low_i"};
  sc_core::sc_in<Uint<kMBits>> m_rd_high_i{"m_rd_high_i"};
  sc_core::sc_out<bool> m_wr_en_o{"m_wr_en_o"};
  sc_core::sc_out<Group> m_wr_addr_o{"m_wr_addr_o"};
  sc_core::sc_out<Uint<kMBits>> m_wr_low_o{"m_wr_low_o"};
  sc_core::sc_out<Uint<kMBits>> m_wr_high_o{"m_wr_high_o"};
  // Memory of A, likewise
  sc_core::sc_out<bool> a_rd_en_o{"a_rd_en_o"};
  sc_core::sc_out<Group> a_rd_addr_o{"a_rd_addr_o"};
  sc_core::sc_in<Uint<kABits>> a_rd_low_i{"a_rd_low_i"};
  sc_core::sc_in<Uint<kABits>> a_rd_high_i{"a_rd_high_i"};
  sc_core::sc_out<bool> a_wr_en_o{"a_wr_en_o"};
  sc_core::sc_out<Group> a_wr_addr_o{"a_wr_addr_o"};
  sc_core::sc_out<Uint<kABits>> a_wr_low_o{"a_wr_low_o"};
  sc_core::sc_out<Uint<kABits>> a_wr_high_o{"a_wr_high_o"};
  // Line buffer: the weights of a last row
  sc_core::sc_out<bool> line_rd_en_o{"line_rd_en_o"};
  sc_core::sc_out<Group> line_rd_addr_o{"line_rd_addr_o"};
  sc_core::sc_in<Pixels> line_rd_data_i{"line_rd_data_i"};
  sc_core::sc_out<bool> line_wr_en_o{"line_wr_en_o"};
  sc_core::sc_out<Group> line_wr_addr_o{"line_wr_addr_o"};
  sc_core::sc_out<Pixels> line_wr_data_o{"line_wr_data_o"};

  SC_HAS_PROCESS(ColumnMomentsShell);
  explicit ColumnMomentsShell(const sc_core::sc_module_name& name) : sc_module(name) {
    SC_CTHREAD(clocked, clk_i.pos());
    reset_signal_is(rst_i, true);
    SC_METHOD(write_line);
    sensitive << s4_drain_row_ << accept_i;
  }

 private:
  // The weights of a last row are kept where its packet was accepted, which is known in the very clock.
  sc_core::sc_signal<bool> s4_drain_row_{"s4_drain_row"};

  void write_line() { line_wr_en_o.write(s4_drain_row_.read() && accept_i.read()); }

  // --- Registers ---
  // Stages 1 to 4: beats and breaks on their way
  bool valid_[4];
  bool break_[3];
  Group group_[4];
  Row row_[4];
  bool first_row_[4];
  bool last_row_[4];
  bool line_end_[4];
  bool one_[4];
  bool two_[4];
  bool grey_[4];
  Pixels weights_[4];
  bool drain_grey_;  // the last row now passing, or the one before, goes to the drain
  // What the memory of M is asked for in this clock
  bool add_;
  bool drain_;
  // Sums: stage 1, their read; 2, M; 3, A
  bool s1_add_, s1_drain_, s1_first_, s1_one_, s1_two_, s1_grey_;
  Group s1_group_, s1_drain_group_;
  Pixels s1_weights_;
  Row s1_row_;
  bool s2_add_, s2_first_, s2_use_sum_, s2_forward_, s2_grey_;
  Group s2_group_;
  Row s2_row_;
  Pixel s2_weight_[kLanes];
  Sum0 s2_old_m0_[kLanes];
  Row s2_old_n_[kLanes];
  bool s3_add_, s3_use_sum_;
  Group s3_group_;
  Sum1 s3_addend_[kLanes];
  Sum1 s3_old_a_[kLanes];
  Sum0 sum_m0_[kLanes];
  Row sum_n_[kLanes];
  Sum1 sum_a_[kLanes];
  // Mode binary, stages 5 to 10
  bool direct_[6];
  bool direct_break_[6];
  Sum0 direct_m0_[kLanes];
  Uint<64> direct_word_[2][2];  // stages 9 and 10
  // Drain
  Uint<bits_for(spec::kMaxColumns / kLanes)> waiting_;
  bool ended_, break_wait_, odd_, active_;
  Group drain_group_;
  Row rows_;
  bool one_row_, one_group_;
  bool d2_first_, d2_valid_, d3_pick_, d1_break_, d2_break_;
  Sum0 d2_m0_[kLanes];
  Row d2_n_[kLanes];
  Pixels d2_weights_;
  Sum1 d3_a_[kLanes];
  bool d_valid_[9];
  bool d_break_[9];
  Sum0 d3_old_m0_[2];
  Sum0 d3_m0_[2];
  Row d3_n_[2];
  Uint<64> d_word_[8][2];  // stages 4 to 11
  bool spoiled_;

  // --- What follows from the registers in their clock ---
  Sum0 now_m0(int lane) const {
    Sum0 base = s2_old_m0_[lane];
    if (s2_use_sum_) {
      base = sum_m0_[lane];
    }
    return base;
  }
  Row now_n(int lane) const {
    Row base = s2_old_n_[lane];
    if (s2_use_sum_) {
      base = sum_n_[lane];
    }
    return base;
  }
  Sum1 now_a(int lane) const {
    Sum1 base = s3_old_a_[lane];
    if (s3_use_sum_) {
      base = sum_a_[lane];
    }
    Sum1 next = base + s3_addend_[lane];
    return next;
  }
  // NOLINTNEXTLINE(performance-unnecessary-value-param): as in column_moments.h
  static Uint<kMBits / 2> word_m(Sum0 m0, Row n) {
    Uint<kMBits / 2> word = n;
    word = (word << spec::kGreyM0Bits) | m0;
    return word;
  }

  void reset() {
    for (int i = 0; i < 4; ++i) {
      valid_[i] = false;
      group_[i] = 0;
      row_[i] = 0;
      first_row_[i] = false;
      last_row_[i] = false;
      line_end_[i] = false;
      one_[i] = false;
      two_[i] = false;
      grey_[i] = false;
      weights_[i] = 0;
      direct_m0_[i] = 0;
      s2_weight_[i] = 0;
      s2_old_m0_[i] = 0;
      s2_old_n_[i] = 0;
      s3_addend_[i] = 0;
      s3_old_a_[i] = 0;
      sum_m0_[i] = 0;
      sum_n_[i] = 0;
      sum_a_[i] = 0;
      d2_m0_[i] = 0;
      d2_n_[i] = 0;
      d3_a_[i] = 0;
    }
    for (int i = 0; i < 3; ++i) {
      break_[i] = false;
    }
    for (int i = 0; i < 6; ++i) {
      direct_[i] = false;
      direct_break_[i] = false;
    }
    for (int i = 0; i < 9; ++i) {
      d_valid_[i] = false;
      d_break_[i] = false;
    }
    for (int i = 0; i < 8; ++i) {
      d_word_[i][0] = 0;
      d_word_[i][1] = 0;
    }
    for (int i = 0; i < 2; ++i) {
      direct_word_[i][0] = 0;
      direct_word_[i][1] = 0;
      d3_old_m0_[i] = 0;
      d3_m0_[i] = 0;
      d3_n_[i] = 0;
    }
    drain_grey_ = false;
    add_ = false;
    drain_ = false;
    s1_add_ = false;
    s1_drain_ = false;
    s1_first_ = false;
    s1_one_ = false;
    s1_two_ = false;
    s1_grey_ = false;
    s1_group_ = 0;
    s1_drain_group_ = 0;
    s1_weights_ = 0;
    s1_row_ = 0;
    s2_add_ = false;
    s2_first_ = false;
    s2_use_sum_ = false;
    s2_forward_ = false;
    s2_grey_ = false;
    s2_group_ = 0;
    s2_row_ = 0;
    s3_add_ = false;
    s3_use_sum_ = false;
    s3_group_ = 0;
    waiting_ = 0;
    ended_ = false;
    break_wait_ = false;
    odd_ = false;
    active_ = false;
    drain_group_ = 0;
    rows_ = 0;
    one_row_ = false;
    one_group_ = false;
    d2_first_ = false;
    d2_valid_ = false;
    d3_pick_ = false;
    d1_break_ = false;
    d2_break_ = false;
    d2_weights_ = 0;
    was_active_ = false;
    spoiled_ = false;
  }

  void clocked() {
    reset();
    show();
    wait();
    while (true) {
      // From the exit to the entry, so that each step sees the registers before it as they were in the clock that ends.
      const bool s4_drain_row = valid_[3] && last_row_[3] && grey_[3];
      bool break_drains = drain_grey_;
      if (valid_[3] && last_row_[3]) {
        break_drains = grey_[3];
      }
      const bool accept = accept_i.read();
      finish_words();
      direct(accept, break_drains);
      drain(s4_drain_row && accept, break_[2] && accept && break_drains);
      if (valid_[3] && first_row_[3]) {
        spoiled_ = false;
      } else if (valid_[3] && !s4_drain_row && was_active_) {
        spoiled_ = true;
      }
      if (valid_[3] && last_row_[3]) {
        drain_grey_ = grey_[3];
      }
      sums();
      enter();
      show();
      wait();
    }
  }

  // Drain, stages 11 to 3: two columns at a time.
  void finish_words() {
    for (int i = 7; i > 0; --i) {
      if (d_valid_[i]) {
        d_word_[i][0] = d_word_[i - 1][0];
        d_word_[i][1] = d_word_[i - 1][1];
      }
    }
    for (int i = 0; i < 2; ++i) {
      if (d_valid_[0]) {
        Sum1 a = d3_a_[i + 2];
        if (d3_pick_) {
          a = d3_a_[i];
        }
        d_word_[0][i] = grey_word(d3_m0_[i], finished_m1(rows_, d3_m0_[i], d3_old_m0_[i], a), d3_n_[i]);
      }
      if (d2_valid_) {
        Sum0 m0 = d2_m0_[i + 2];
        Row n = d2_n_[i + 2];
        Pixel weight = lane_of(d2_weights_, i + 2);
        if (d2_first_) {
          m0 = d2_m0_[i];
          n = d2_n_[i];
          weight = lane_of(d2_weights_, i);
        }
        d3_old_m0_[i] = m0;
        d3_m0_[i] = next_m0(m0, weight);
        d3_n_[i] = next_n(n, weight);
      }
    }
    for (int i = 8; i > 0; --i) {
      d_valid_[i] = d_valid_[i - 1];
      d_break_[i] = d_break_[i - 1];
    }
    d_valid_[0] = d2_valid_;
    d_break_[0] = d2_break_;
    d2_break_ = d1_break_;
    d3_pick_ = d2_first_;
    const Uint<kMBits> m_low = m_rd_low_i.read();
    const Uint<kMBits> m_high = m_rd_high_i.read();
    const Uint<kABits> a_low = a_rd_low_i.read();
    const Uint<kABits> a_high = a_rd_high_i.read();
    for (int lane = 0; lane < kLanes; ++lane) {
      Uint<kMBits / 2> m = m_low >> (kMBits / 2 * lane);
      Sum1 a = a_low >> (kABits / 2 * lane);
      if (lane >= 2) {
        m = m_high >> (kMBits / 2 * (lane - 2));
        a = a_high >> (kABits / 2 * (lane - 2));
      }
      if (d2_first_) {
        d3_a_[lane] = a;
        if (one_row_) {
          d3_a_[lane] = 0;
        } else if (one_group_) {
          d3_a_[lane] = sum_a_[lane];
        }
      }
      if (odd_) {
        d2_m0_[lane] = m;
        d2_n_[lane] = m >> spec::kGreyM0Bits;
        if (one_row_) {
          d2_m0_[lane] = 0;
          d2_n_[lane] = 0;
        } else if (one_group_) {
          d2_m0_[lane] = sum_m0_[lane];
          d2_n_[lane] = sum_n_[lane];
        }
      }
    }
    if (odd_) {
      d2_weights_ = line_rd_data_i.read();
    }
    d2_valid_ = odd_ || d2_first_;
    d2_first_ = odd_;
  }

  // Mode binary, stages 10 to 5.
  void direct(bool accept, bool break_drains) {
    if (direct_[4]) {
      direct_word_[1][0] = direct_word_[0][0];
      direct_word_[1][1] = direct_word_[0][1];
    }
    if (direct_[3]) {
      for (int pair = 0; pair < 2; ++pair) {
        const Uint<64> upper = binary_word(direct_m0_[2 * pair + 1], sum_a_[2 * pair + 1]);
        direct_word_[0][pair] = (upper << spec::kBinaryWordBits) | binary_word(direct_m0_[2 * pair], sum_a_[2 * pair]);
      }
    }
    if (direct_[2]) {
      for (int lane = 0; lane < kLanes; ++lane) {
        direct_m0_[lane] = sum_m0_[lane];
      }
    }
    for (int i = 5; i > 0; --i) {
      direct_[i] = direct_[i - 1];
      direct_break_[i] = direct_break_[i - 1];
    }
    direct_[0] = valid_[3] && last_row_[3] && !grey_[3] && accept;
    direct_break_[0] = break_[2] && accept && !break_drains;
  }

  // What waits in the line buffer, and its reads.
  bool was_active_;
  void drain(bool push, bool broken) {
    was_active_ = active_;
    const bool last_read = drain_ && ended_ && waiting_ == 1;
    const bool break_now = break_wait_ && waiting_ == 0 && !odd_;
    const bool over = last_read || break_now;
    d1_break_ = break_now;
    odd_ = drain_;
    if (push && !drain_) {
      waiting_ = waiting_ + 1;
    } else if (!push && drain_) {
      waiting_ = waiting_ - 1;
    }
    if ((push && line_end_[3]) || broken) {
      ended_ = true;
    } else if (over) {
      ended_ = false;
    }
    if (broken) {
      break_wait_ = true;
    } else if (break_now) {
      break_wait_ = false;
    }
    if (push) {
      active_ = true;
      rows_ = row_[3];
      one_row_ = first_row_[3];
      one_group_ = one_[3];
    } else if (over) {
      active_ = false;
    }
    s1_drain_ = drain_;
    if (drain_) {
      s1_drain_group_ = drain_group_;
    }
    if (over) {
      drain_group_ = 0;
    } else if (drain_) {
      drain_group_ = drain_group_ + 1;
    }
  }

  // Stages 3 to 1 of the sums.
  void sums() {
    // The beat two clocks ahead had the same address, and its sum is not in the memory yet.
    const bool forward = s1_two_ && s2_add_ && s3_add_;
    const Uint<kMBits> m_low = m_rd_low_i.read();
    const Uint<kMBits> m_high = m_rd_high_i.read();
    const Uint<kABits> a_low = a_rd_low_i.read();
    const Uint<kABits> a_high = a_rd_high_i.read();
    for (int lane = 0; lane < kLanes; ++lane) {
      Uint<kMBits / 2> m = m_low >> (kMBits / 2 * lane);
      Sum1 a = a_low >> (kABits / 2 * lane);
      if (lane >= 2) {
        m = m_high >> (kMBits / 2 * (lane - 2));
        a = a_high >> (kABits / 2 * (lane - 2));
      }
      const Sum0 m0 = now_m0(lane);
      const Row n = now_n(lane);
      const Sum1 next_sum_a = now_a(lane);
      const Sum0 old_sum_m0 = sum_m0_[lane];
      const Row old_sum_n = sum_n_[lane];
      const Sum1 old_sum_a = sum_a_[lane];
      if (s3_add_) {
        sum_a_[lane] = next_sum_a;
      }
      if (s2_add_) {
        sum_m0_[lane] = next_m0(m0, s2_weight_[lane]);
        sum_n_[lane] = next_n(n, s2_weight_[lane]);
        s3_addend_[lane] = addend_of(m0, s2_weight_[lane], s2_row_, s2_grey_);
        s3_old_a_[lane] = a;
        if (s2_first_) {
          s3_old_a_[lane] = 0;
        } else if (s2_forward_) {
          s3_old_a_[lane] = old_sum_a;
        }
      }
      if (s1_add_) {
        s2_weight_[lane] = lane_of(s1_weights_, lane);
        s2_old_m0_[lane] = m;
        s2_old_n_[lane] = m >> spec::kGreyM0Bits;
        if (s1_first_) {
          s2_old_m0_[lane] = 0;
          s2_old_n_[lane] = 0;
        } else if (forward) {
          s2_old_m0_[lane] = old_sum_m0;
          s2_old_n_[lane] = old_sum_n;
        }
      }
    }
    s3_add_ = s2_add_;
    if (s2_add_) {
      s3_group_ = s2_group_;
      s3_use_sum_ = s2_use_sum_;
    }
    s2_add_ = s1_add_;
    if (s1_add_) {
      s2_group_ = s1_group_;
      s2_first_ = s1_first_;
      s2_use_sum_ = s1_one_ && !s1_first_;
      s2_forward_ = forward;
      s2_grey_ = s1_grey_;
      s2_row_ = s1_row_;
    }
    s1_add_ = add_;
    if (add_) {
      s1_group_ = group_[3];
      s1_first_ = first_row_[3];
      s1_one_ = one_[3];
      s1_two_ = two_[3];
      s1_grey_ = grey_[3];
      s1_weights_ = weights_[3];
      s1_row_ = row_[3];
    }
  }

  // Stages 4 to 1.
  void enter() {
    for (int i = 3; i > 0; --i) {
      valid_[i] = valid_[i - 1];
      group_[i] = group_[i - 1];
      row_[i] = row_[i - 1];
      first_row_[i] = first_row_[i - 1];
      last_row_[i] = last_row_[i - 1];
      line_end_[i] = line_end_[i - 1];
      one_[i] = one_[i - 1];
      two_[i] = two_[i - 1];
      grey_[i] = grey_[i - 1];
      weights_[i] = weights_[i - 1];
    }
    break_[2] = break_[1];
    break_[1] = break_[0];
    break_[0] = break_i.read();
    valid_[0] = beat_valid_i.read();
    group_[0] = beat_group_i.read();
    row_[0] = beat_row_i.read();
    first_row_[0] = beat_first_row_i.read();
    last_row_[0] = beat_last_row_i.read();
    line_end_[0] = beat_line_end_i.read();
    one_[0] = one_group_i.read();
    two_[0] = two_groups_i.read();
    grey_[0] = mode_i.read() != spec::kModeBinary;
    const Pixels pixels = beat_pixels_i.read();
    const Pixel threshold = threshold_i.read();
    const ModeBits mode = mode_i.read();
    Pixels weights = 0;
    for (int lane = kLanes - 1; lane >= 0; --lane) {
      weights = (weights << spec::kPixelBits) | weight_of(lane_of(pixels, lane), threshold, mode);
    }
    weights_[0] = weights;
  }

  // The outputs of the clock that begins.
  void show() {
    const bool s4_drain_row = valid_[3] && last_row_[3] && grey_[3];
    // A first row needs no read and may pass a drain; any other row meets one only after a change of size: see
    // spoiled_o.
    add_ = valid_[3] && !s4_drain_row && (first_row_[3] || !active_);
    drain_ = waiting_ != 0 && !odd_;
    s4_drain_row_.write(s4_drain_row);
    line_wr_addr_o.write(group_[3]);
    line_wr_data_o.write(weights_[3]);
    line_rd_en_o.write(drain_);
    line_rd_addr_o.write(drain_group_);
    Group m_address = group_[3];
    if (drain_) {
      m_address = drain_group_;
    }
    m_rd_en_o.write(add_ || drain_);
    m_rd_addr_o.write(m_address);
    Group a_address = s1_group_;
    if (s1_drain_) {
      a_address = s1_drain_group_;
    }
    a_rd_en_o.write(s1_add_ || s1_drain_);
    a_rd_addr_o.write(a_address);

    Uint<kMBits> m_low = 0;
    Uint<kMBits> m_high = 0;
    Uint<kABits> a_low = 0;
    Uint<kABits> a_high = 0;
    for (int lane = 1; lane >= 0; --lane) {
      m_low = (m_low << (kMBits / 2)) |
              word_m(next_m0(now_m0(lane), s2_weight_[lane]), next_n(now_n(lane), s2_weight_[lane]));
      m_high = (m_high << (kMBits / 2)) |
               word_m(next_m0(now_m0(lane + 2), s2_weight_[lane + 2]), next_n(now_n(lane + 2), s2_weight_[lane + 2]));
      a_low = (a_low << (kABits / 2)) | now_a(lane);
      a_high = (a_high << (kABits / 2)) | now_a(lane + 2);
    }
    m_wr_en_o.write(s2_add_);
    m_wr_addr_o.write(s2_group_);
    m_wr_low_o.write(m_low);
    m_wr_high_o.write(m_high);
    a_wr_en_o.write(s3_add_);
    a_wr_addr_o.write(s3_group_);
    a_wr_low_o.write(a_low);
    a_wr_high_o.write(a_high);

    Uint<64> low = 0;
    Uint<64> high = 0;
    if (direct_[5]) {
      low = direct_word_[1][0];
      high = direct_word_[1][1];
    } else if (d_valid_[8]) {
      low = d_word_[7][0];
      high = d_word_[7][1];
    }
    WideUint<128> data(high);
    data = data << 64;
    data = data | WideUint<128>(low);
    moments_valid_o.write(direct_[5] || d_valid_[8]);
    moments_data_o.write(data);
    moments_break_o.write(direct_break_[5] || d_break_[8]);
    spoiled_o.write(spoiled_);
  }
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_COLUMN_MOMENTS_SHELL_H
