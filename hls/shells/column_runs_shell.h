// The strongest run of every column as a SystemC module with the ports of rtl/moments/sp_column_runs.sv, for compilers
// that translate clocked threads; F is a MomentsFormats.
//
// With the same inputs in every clock the outputs equal those of the RTL, in a grey build, in every clock: one beat a
// clock, no bubble. The tests compare both clock by clock. The timing in docs/using-the-circuits.md thus holds for this
// module, too.
//
// The operations on pixels, runs and words are the pure functions of hls/moments_arithmetic.h and
// hls/runs_arithmetic.h. This file decides when they happen, with the runs in runs_sums.h and the drain in
// runs_drain.h. Unlike in the RTL, a run and its comparison with the strongest are made in one clock, and so is a word,
// which then passes empty registers; a synthesizer may move these into the logic. Its reads and writes of the memories
// are one clock ahead of the RTL's or more. The memories are outside, behind ports: all of them are read and written
// with the same addresses, each with one port that writes and one that reads a clock later, like sp_ram.
#ifndef SELFPROJ_HLS_SHELLS_COLUMN_RUNS_SHELL_H
#define SELFPROJ_HLS_SHELLS_COLUMN_RUNS_SHELL_H

#include <systemc>

#include "hls/shells/moments_ports.h"
#include "hls/shells/runs_drain.h"
#include "hls/shells/runs_sums.h"

namespace selfproj {
namespace hls {

template <typename F>
class ColumnRunsShellOf : public MomentsPorts<F> {
  using Base = MomentsPorts<F>;

 public:
  using Group = typename F::Group;
  using Payload = typename F::Payload;
  using OpenWords = typename RunsWords<F>::Open;
  using BestWords = typename RunsWords<F>::Best;
  using RestWords = typename RunsWords<F>::Rest;

  sc_core::sc_in<bool> strongest_i{"strongest_i"};
  sc_core::sc_in<Uint<2>> gap_i{"gap_i"};

  // The memories of the runs
  sc_core::sc_out<bool> rd_en_o{"rd_en_o"};
  sc_core::sc_out<Group> rd_addr_o{"rd_addr_o"};
  sc_core::sc_out<bool> wr_en_o{"wr_en_o"};
  sc_core::sc_out<Group> wr_addr_o{"wr_addr_o"};
  // Memory of the open runs
  sc_core::sc_in<OpenWords> open_rd_i{"open_rd_i"};
  sc_core::sc_out<OpenWords> open_wr_o{"open_wr_o"};
  // Memory of the ended runs: M0 of the strongest and of the second, their number
  sc_core::sc_in<BestWords> best_rd_i{"best_rd_i"};
  sc_core::sc_out<BestWords> best_wr_o{"best_wr_o"};
  // and what else the strongest has
  sc_core::sc_in<RestWords> rest_rd_i{"rest_rd_i"};
  sc_core::sc_out<RestWords> rest_wr_o{"rest_wr_o"};

  SC_HAS_PROCESS(ColumnRunsShellOf);
  explicit ColumnRunsShellOf(const sc_core::sc_module_name& name) : Base(name) {
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
  RunsBeat<F> beat_[4];
  RunsSums<F> sums_;
  RunsDrain<F> draining_;

  void reset() {
    for (int i = 0; i < 4; ++i) {
      beat_[i].reset();
    }
    this->reset_common();
    sums_.reset();
    draining_.reset();
  }

  void clocked() {
    reset();
    show_reset();
    wait();
    while (true) {
      // From the exit to the entry, so that each step sees the registers before it as they were in the clock that ends.
      bool accept = this->accept_i.read();
      bool s4_drain_row = beat_[3].drains();
      OpenWords open = open_rd_i.read();
      BestWords best = best_rd_i.read();
      RestWords rest = rest_rd_i.read();
      RunsRead<F> read;
      read.take(open, best, rest);
      typename F::Pixels line = this->line_rd_data_i.read();
      draining_.finish_words(read, sums_, line);
      bool push = s4_drain_row && accept;
      bool broken = break_[2] && accept;
      draining_.step(drain_, push, broken, beat_[3]);
      this->spoil(beat_[3], draining_.order.was_active);
      sums_.step(add_, beat_[3], read);
      enter();
      show();
      wait();
    }
  }

  // Stages 4 to 1.
  void enter() {
    for (int i = 3; i > 0; --i) {
      beat_[i] = beat_[i - 1];
    }
    this->enter_beat(beat_[0]);
    beat_[0].strongest = strongest_i.read();
    beat_[0].gap = gap_i.read();
  }

  // The outputs of a reset: see show_reset_common().
  void show_reset() {
    this->show_reset_common();
    rd_en_o.write(false);
    rd_addr_o.write(0);
    wr_en_o.write(false);
    wr_addr_o.write(0);
    open_wr_o.write(0);
    best_wr_o.write(0);
    rest_wr_o.write(0);
  }

  // The outputs of the clock that begins.
  void show() {
    this->show_requests(beat_[3], draining_.order);
    Group address = beat_[3].group;
    if (drain_) {
      address = draining_.order.group;
    }
    rd_en_o.write(add_ || drain_);
    rd_addr_o.write(address);
    wr_en_o.write(sums_.s2_add);
    wr_addr_o.write(sums_.s2_group);
    OpenWords open = sums_.open_words();
    BestWords best = sums_.best_words();
    RestWords rest = sums_.rest_words();
    open_wr_o.write(open);
    best_wr_o.write(best);
    rest_wr_o.write(rest);

    Payload data = 0;
    for (int i = F::kHalf - 1; i >= 0; --i) {
      Uint<64> word = draining_.out(i);
      data = (data << 64) | Payload(word);
    }
    bool valid = draining_.out_valid();
    this->show_payload(valid, data, draining_.d_break[RunsDrain<F>::kStages]);
  }
};

// That of the default formats
class ColumnRunsShell : public ColumnRunsShellOf<FourOfEight> {
 public:
  explicit ColumnRunsShell(const sc_core::sc_module_name& name) : ColumnRunsShellOf<FourOfEight>(name) {}
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_COLUMN_RUNS_SHELL_H
