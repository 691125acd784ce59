// The column moments as a SystemC module with the ports of rtl/moments/sp_column_moments.sv, for compilers that
// translate clocked threads; F is a MomentsFormats.
//
// With the same inputs in every clock the outputs equal those of the RTL in every clock: one beat a clock, no bubble.
// The tests compare both clock by clock. The timing in docs/using-the-circuits.md thus holds for this module, too.
//
// The operations on pixels, sums and words are the pure functions of hls/moments_arithmetic.h. This file decides when
// they happen, with the sums in moments_sums.h and the drain in moments_drain.h. moments_ports.h has what both circuits
// share. The registers have the names of the RTL's. Unlike there, sums are in one piece, and a word is finished in one
// clock and then passes seven registers, which a synthesizer may move into the additions and the multiplication. Its
// reads and writes of the memories are therefore one clock ahead of the RTL's. The memories are outside, behind ports.
// Each has one port that writes and one that reads a clock later, like sp_ram.
#ifndef SELFPROJ_HLS_SHELLS_COLUMN_MOMENTS_SHELL_H
#define SELFPROJ_HLS_SHELLS_COLUMN_MOMENTS_SHELL_H

#include <systemc>

#include "hls/shells/moments_drain.h"
#include "hls/shells/moments_ports.h"
#include "hls/shells/moments_sums.h"

namespace selfproj {
namespace hls {

template <typename F>
class ColumnMomentsShellOf : public MomentsPorts<F> {
  using Base = MomentsPorts<F>;
  using Words = MomentsWords<F>;

 public:
  using Group = typename F::Group;
  using Payload = typename F::Payload;
  using MWord = typename Words::M;
  using AWord = typename Words::A;

  // The frame has the columns of one beat, or of two
  sc_core::sc_in<bool> one_group_i{"one_group_i"};
  sc_core::sc_in<bool> two_groups_i{"two_groups_i"};

  // Memory of M0 and N: one word for the first half of the lanes, one for the second
  sc_core::sc_out<bool> m_rd_en_o{"m_rd_en_o"};
  sc_core::sc_out<Group> m_rd_addr_o{"m_rd_addr_o"};
  sc_core::sc_in<MWord> m_rd_low_i{"m_rd_low_i"};
  sc_core::sc_in<MWord> m_rd_high_i{"m_rd_high_i"};
  sc_core::sc_out<bool> m_wr_en_o{"m_wr_en_o"};
  sc_core::sc_out<Group> m_wr_addr_o{"m_wr_addr_o"};
  sc_core::sc_out<MWord> m_wr_low_o{"m_wr_low_o"};
  sc_core::sc_out<MWord> m_wr_high_o{"m_wr_high_o"};
  // Memory of A, in the same way
  sc_core::sc_out<bool> a_rd_en_o{"a_rd_en_o"};
  sc_core::sc_out<Group> a_rd_addr_o{"a_rd_addr_o"};
  sc_core::sc_in<AWord> a_rd_low_i{"a_rd_low_i"};
  sc_core::sc_in<AWord> a_rd_high_i{"a_rd_high_i"};
  sc_core::sc_out<bool> a_wr_en_o{"a_wr_en_o"};
  sc_core::sc_out<Group> a_wr_addr_o{"a_wr_addr_o"};
  sc_core::sc_out<AWord> a_wr_low_o{"a_wr_low_o"};
  sc_core::sc_out<AWord> a_wr_high_o{"a_wr_high_o"};

  SC_HAS_PROCESS(ColumnMomentsShellOf);
  explicit ColumnMomentsShellOf(const sc_core::sc_module_name& name) : Base(name) {
    SC_CTHREAD(clocked, this->clk_i.pos());
    this->reset_signal_is(this->rst_i, true);
  }

 private:
  using Base::add_;
  using Base::break_;
  using Base::drain_;
  using Base::wait;

  // --- Registers ---
  // Stages 1 to 4: beats and breaks on their way
  MomentsBeat<F> beat_[4];
  bool drain_grey_;  // the last row that passes now or passed last goes to the drain
  MomentsSums<F> sums_;
  MomentsDrain<F> draining_;
  // Mode binary, stages 5 to 10
  bool direct_[6];
  bool direct_break_[6];
  typename F::Sum0 direct_m0_[F::kLanes];
  Uint<64> direct_word_[2][F::kHalf];  // stages 9 and 10

  void reset() {
    for (int i = 0; i < 4; ++i) {
      beat_[i].reset();
    }
    for (int lane = 0; lane < F::kLanes; ++lane) {
      direct_m0_[lane] = 0;
    }
    this->reset_common();
    for (int i = 0; i < 6; ++i) {
      direct_[i] = false;
      direct_break_[i] = false;
    }
    for (int i = 0; i < 2; ++i) {
      for (int pair = 0; pair < F::kHalf; ++pair) {
        direct_word_[i][pair] = 0;
      }
    }
    drain_grey_ = false;
    sums_.reset();
    draining_.reset();
  }

  void clocked() {
    reset();
    show_reset();
    wait();
    while (true) {
      // From the exit to the entry, so that each step sees the registers before it as they were in the clock that ends.
      const bool valid = beat_[3].valid;
      bool s4_drain_row = beat_[3].drains();
      bool break_drains = drain_grey_;
      if (valid && beat_[3].last_row) {
        break_drains = beat_[3].grey;
      }
      bool accept = this->accept_i.read();
      MWord m_low = m_rd_low_i.read();
      MWord m_high = m_rd_high_i.read();
      AWord a_low = a_rd_low_i.read();
      AWord a_high = a_rd_high_i.read();
      MomentsRead<F> read;
      read.take(m_low, m_high, a_low, a_high);
      typename F::Pixels line = this->line_rd_data_i.read();
      draining_.finish_words(read, sums_, line);
      direct(accept, break_drains);
      bool push = s4_drain_row && accept;
      bool broken = break_[2] && accept && break_drains;
      draining_.step(drain_, push, broken, beat_[3]);
      this->spoil(beat_[3], draining_.order.was_active);
      if (valid && beat_[3].last_row) {
        drain_grey_ = beat_[3].grey;
      }
      sums_.step(add_, beat_[3], read);
      enter();
      show();
      wait();
    }
  }

  // Mode binary, stages 10 to 5.
  void direct(bool accept, bool break_drains) {
    if (direct_[4]) {
      for (int pair = 0; pair < F::kHalf; ++pair) {
        direct_word_[1][pair] = direct_word_[0][pair];
      }
    }
    if (direct_[3]) {
      for (int pair = 0; pair < F::kHalf; ++pair) {
        Uint<64> upper = binary_word<F>(direct_m0_[2 * pair + 1], sums_.sum_a[2 * pair + 1]);
        Uint<64> lower = binary_word<F>(direct_m0_[2 * pair], sums_.sum_a[2 * pair]);
        direct_word_[0][pair] = (upper << spec::kBinaryWordBits) | lower;
      }
    }
    if (direct_[2]) {
      for (int lane = 0; lane < F::kLanes; ++lane) {
        direct_m0_[lane] = sums_.sum_m0[lane];
      }
    }
    for (int i = 5; i > 0; --i) {
      direct_[i] = direct_[i - 1];
      direct_break_[i] = direct_break_[i - 1];
    }
    direct_[0] = beat_[3].valid && beat_[3].last_row && !beat_[3].grey && accept;
    direct_break_[0] = break_[2] && accept && !break_drains;
  }

  // Stages 4 to 1.
  void enter() {
    for (int i = 3; i > 0; --i) {
      beat_[i] = beat_[i - 1];
    }
    this->enter_beat(beat_[0]);
    beat_[0].one_group = one_group_i.read();
    beat_[0].two_groups = two_groups_i.read();
  }

  // The outputs of a reset: see show_reset_common().
  void show_reset() {
    this->show_reset_common();
    m_rd_en_o.write(false);
    m_rd_addr_o.write(0);
    m_wr_en_o.write(false);
    m_wr_addr_o.write(0);
    m_wr_low_o.write(0);
    m_wr_high_o.write(0);
    a_rd_en_o.write(false);
    a_rd_addr_o.write(0);
    a_wr_en_o.write(false);
    a_wr_addr_o.write(0);
    a_wr_low_o.write(0);
    a_wr_high_o.write(0);
  }

  // The outputs of the clock that begins.
  void show() {
    this->show_requests(beat_[3], draining_.order);
    Group m_address = beat_[3].group;
    if (drain_) {
      m_address = draining_.order.group;
    }
    m_rd_en_o.write(add_ || drain_);
    m_rd_addr_o.write(m_address);
    Group a_address = sums_.s1_group;
    if (draining_.order.odd) {
      a_address = draining_.order.s1_group;
    }
    a_rd_en_o.write(sums_.s1_add || draining_.order.odd);
    a_rd_addr_o.write(a_address);

    sums_.add();
    MWord m_low = 0;
    MWord m_high = 0;
    AWord a_low = 0;
    AWord a_high = 0;
    for (int lane = F::kHalf - 1; lane >= 0; --lane) {
      Uint<Words::kMBits> m_of_low = sums_.word_m(lane);
      Uint<Words::kMBits> m_of_high = sums_.word_m(lane + F::kHalf);
      m_low = (m_low << Words::kMBits) | MWord(m_of_low);
      m_high = (m_high << Words::kMBits) | MWord(m_of_high);
      a_low = (a_low << F::kM1Bits) | AWord(sums_.added_a[lane]);
      a_high = (a_high << F::kM1Bits) | AWord(sums_.added_a[lane + F::kHalf]);
    }
    m_wr_en_o.write(sums_.s2_add);
    m_wr_addr_o.write(sums_.s2_group);
    m_wr_low_o.write(m_low);
    m_wr_high_o.write(m_high);
    a_wr_en_o.write(sums_.s3_add);
    a_wr_addr_o.write(sums_.s3_group);
    a_wr_low_o.write(a_low);
    a_wr_high_o.write(a_high);

    Payload data = 0;
    for (int i = F::kHalf - 1; i >= 0; --i) {
      Uint<64> word = 0;
      if (direct_[5]) {
        word = direct_word_[1][i];
      } else if (draining_.d_valid[8]) {
        word = draining_.d_word[7][i];
      }
      data = (data << 64) | Payload(word);
    }
    this->show_payload(direct_[5] || draining_.d_valid[8], data, direct_break_[5] || draining_.d_break[8]);
  }
};

// That of the default formats
class ColumnMomentsShell : public ColumnMomentsShellOf<FourOfEight> {
 public:
  explicit ColumnMomentsShell(const sc_core::sc_module_name& name) : ColumnMomentsShellOf<FourOfEight>(name) {}
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_COLUMN_MOMENTS_SHELL_H
