// The strongest run of every column as a SystemC module with the ports of rtl/moments/sp_column_runs.sv, for compilers
// that translate clocked threads.
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

class ColumnRunsShell : public MomentsPorts {
 public:
  sc_core::sc_in<bool> strongest_i{"strongest_i"};
  sc_core::sc_in<Uint<2>> gap_i{"gap_i"};

  // The memories of the runs
  sc_core::sc_out<bool> rd_en_o{"rd_en_o"};
  sc_core::sc_out<Group> rd_addr_o{"rd_addr_o"};
  sc_core::sc_out<bool> wr_en_o{"wr_en_o"};
  sc_core::sc_out<Group> wr_addr_o{"wr_addr_o"};
  // Memory of the open runs, a word for each lane
  sc_core::sc_in<Uint<kOpenBits>> open_rd0_i{"open_rd0_i"};
  sc_core::sc_in<Uint<kOpenBits>> open_rd1_i{"open_rd1_i"};
  sc_core::sc_in<Uint<kOpenBits>> open_rd2_i{"open_rd2_i"};
  sc_core::sc_in<Uint<kOpenBits>> open_rd3_i{"open_rd3_i"};
  sc_core::sc_out<Uint<kOpenBits>> open_wr0_o{"open_wr0_o"};
  sc_core::sc_out<Uint<kOpenBits>> open_wr1_o{"open_wr1_o"};
  sc_core::sc_out<Uint<kOpenBits>> open_wr2_o{"open_wr2_o"};
  sc_core::sc_out<Uint<kOpenBits>> open_wr3_o{"open_wr3_o"};
  // Memory of the ended runs: M0 of the strongest and of the second, their number
  sc_core::sc_in<Uint<kBestBits>> best_rd0_i{"best_rd0_i"};
  sc_core::sc_in<Uint<kBestBits>> best_rd1_i{"best_rd1_i"};
  sc_core::sc_in<Uint<kBestBits>> best_rd2_i{"best_rd2_i"};
  sc_core::sc_in<Uint<kBestBits>> best_rd3_i{"best_rd3_i"};
  sc_core::sc_out<Uint<kBestBits>> best_wr0_o{"best_wr0_o"};
  sc_core::sc_out<Uint<kBestBits>> best_wr1_o{"best_wr1_o"};
  sc_core::sc_out<Uint<kBestBits>> best_wr2_o{"best_wr2_o"};
  sc_core::sc_out<Uint<kBestBits>> best_wr3_o{"best_wr3_o"};
  // and what else the strongest has
  sc_core::sc_in<Uint<kRestBits>> rest_rd0_i{"rest_rd0_i"};
  sc_core::sc_in<Uint<kRestBits>> rest_rd1_i{"rest_rd1_i"};
  sc_core::sc_in<Uint<kRestBits>> rest_rd2_i{"rest_rd2_i"};
  sc_core::sc_in<Uint<kRestBits>> rest_rd3_i{"rest_rd3_i"};
  sc_core::sc_out<Uint<kRestBits>> rest_wr0_o{"rest_wr0_o"};
  sc_core::sc_out<Uint<kRestBits>> rest_wr1_o{"rest_wr1_o"};
  sc_core::sc_out<Uint<kRestBits>> rest_wr2_o{"rest_wr2_o"};
  sc_core::sc_out<Uint<kRestBits>> rest_wr3_o{"rest_wr3_o"};

  SC_HAS_PROCESS(ColumnRunsShell);
  explicit ColumnRunsShell(const sc_core::sc_module_name& name) : MomentsPorts(name) {
    SC_CTHREAD(clocked, clk_i.pos());
    reset_signal_is(rst_i, true);
  }

 private:
  // --- Registers ---
  // Stages 1 to 4: beats and breaks on their way
  RunsBeat beat_[4];
  RunsSums sums_;
  RunsDrain draining_;

  void reset() {
    for (int i = 0; i < 4; ++i) {
      beat_[i].reset();
    }
    reset_common();
    sums_.reset();
    draining_.reset();
  }

  void clocked() {
    reset();
    show_reset();
    wait();
    while (true) {
      // From the exit to the entry, so that each step sees the registers before it as they were in the clock that ends.
      bool accept = accept_i.read();
      bool s4_drain_row = beat_[3].drains();
      RunsRead read;
      read_memories(read);
      Pixels line = line_rd_data_i.read();
      draining_.finish_words(read, sums_, line);
      bool push = s4_drain_row && accept;
      bool broken = break_[2] && accept;
      draining_.step(drain_, push, broken, beat_[3]);
      spoil(beat_[3], draining_.order.was_active);
      sums_.step(add_, beat_[3], read);
      enter();
      show();
      wait();
    }
  }

  void read_memories(RunsRead& read) {
    Uint<kOpenBits> open0 = open_rd0_i.read();
    Uint<kBestBits> best0 = best_rd0_i.read();
    Uint<kRestBits> rest0 = rest_rd0_i.read();
    read.take(0, open0, best0, rest0);
    Uint<kOpenBits> open1 = open_rd1_i.read();
    Uint<kBestBits> best1 = best_rd1_i.read();
    Uint<kRestBits> rest1 = rest_rd1_i.read();
    read.take(1, open1, best1, rest1);
    Uint<kOpenBits> open2 = open_rd2_i.read();
    Uint<kBestBits> best2 = best_rd2_i.read();
    Uint<kRestBits> rest2 = rest_rd2_i.read();
    read.take(2, open2, best2, rest2);
    Uint<kOpenBits> open3 = open_rd3_i.read();
    Uint<kBestBits> best3 = best_rd3_i.read();
    Uint<kRestBits> rest3 = rest_rd3_i.read();
    read.take(3, open3, best3, rest3);
  }

  // Stages 4 to 1.
  void enter() {
    for (int i = 3; i > 0; --i) {
      beat_[i] = beat_[i - 1];
    }
    enter_beat(beat_[0]);
    beat_[0].strongest = strongest_i.read();
    beat_[0].gap = gap_i.read();
  }

  // The outputs of a reset: see show_reset_common().
  void show_reset() {
    show_reset_common();
    rd_en_o.write(false);
    rd_addr_o.write(0);
    wr_en_o.write(false);
    wr_addr_o.write(0);
    open_wr0_o.write(0);
    open_wr1_o.write(0);
    open_wr2_o.write(0);
    open_wr3_o.write(0);
    best_wr0_o.write(0);
    best_wr1_o.write(0);
    best_wr2_o.write(0);
    best_wr3_o.write(0);
    rest_wr0_o.write(0);
    rest_wr1_o.write(0);
    rest_wr2_o.write(0);
    rest_wr3_o.write(0);
  }

  // The outputs of the clock that begins.
  void show() {
    show_requests(beat_[3], draining_.order);
    Group address = beat_[3].group;
    if (drain_) {
      address = draining_.order.group;
    }
    rd_en_o.write(add_ || drain_);
    rd_addr_o.write(address);
    wr_en_o.write(sums_.s2_add);
    wr_addr_o.write(sums_.s2_group);
    write_memories();

    Uint<64> low = draining_.out_low();
    Uint<64> high = draining_.out_high();
    bool valid = draining_.out_valid();
    show_payload(valid, low, high, draining_.d_break[RunsDrain::kStages]);
  }

  void write_memories() {
    Uint<kOpenBits> open0 = open_word(sums_.s2_open[0]);
    Uint<kBestBits> best0 = best_word(sums_.s2_ended[0]);
    Uint<kRestBits> rest0 = rest_word(sums_.s2_ended[0]);
    open_wr0_o.write(open0);
    best_wr0_o.write(best0);
    rest_wr0_o.write(rest0);
    Uint<kOpenBits> open1 = open_word(sums_.s2_open[1]);
    Uint<kBestBits> best1 = best_word(sums_.s2_ended[1]);
    Uint<kRestBits> rest1 = rest_word(sums_.s2_ended[1]);
    open_wr1_o.write(open1);
    best_wr1_o.write(best1);
    rest_wr1_o.write(rest1);
    Uint<kOpenBits> open2 = open_word(sums_.s2_open[2]);
    Uint<kBestBits> best2 = best_word(sums_.s2_ended[2]);
    Uint<kRestBits> rest2 = rest_word(sums_.s2_ended[2]);
    open_wr2_o.write(open2);
    best_wr2_o.write(best2);
    rest_wr2_o.write(rest2);
    Uint<kOpenBits> open3 = open_word(sums_.s2_open[3]);
    Uint<kBestBits> best3 = best_word(sums_.s2_ended[3]);
    Uint<kRestBits> rest3 = rest_word(sums_.s2_ended[3]);
    open_wr3_o.write(open3);
    best_wr3_o.write(best3);
    rest_wr3_o.write(rest3);
  }
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_COLUMN_RUNS_SHELL_H
