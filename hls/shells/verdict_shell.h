// The verdict of frames as a SystemC module with the ports of rtl/verdict/sp_verdict.sv, for compilers that translate
// clocked threads. It has two sections a bank.
//
// With the same inputs in every clock the outputs equal those of the RTL in every clock in which they count: one beat a
// clock, no bubble. The tests compare both clock by clock. Limits, states and hits are the pure functions of
// hls/verdict_arithmetic.h; verdict_parts.h says where parts begin. This file decides when columns are judged. Unlike
// in the RTL a comparison with a limit is one clock, and so are the runs of columns in a group; the flag of the frame's
// end waits, so that the verdict comes when the RTL's does.
//
// The memories are outside, behind ports. Each has one port that writes and one that reads a clock later, like sp_ram.
// Words of the registers and limits are written from outside, past this module: write_i says when.
#ifndef SELFPROJ_HLS_SHELLS_VERDICT_SHELL_H
#define SELFPROJ_HLS_SHELLS_VERDICT_SHELL_H

#include <systemc>

#include "hls/moments_arithmetic.h"
#include "hls/shells/verdict_parts.h"
#include "hls/verdict_arithmetic.h"

namespace selfproj {
namespace hls {

constexpr int kLaneBits = 2;
static_assert(1 << kLaneBits == kLanes, "a column is {group, lane}");
constexpr int kGroupIndexBits = bits_for(spec::kMaxColumns / kLanes - 1);
using VerdictColumns = Uint<bits_for(spec::kMaxColumns)>;          // 0..kMaxColumns
using VerdictGroups = Uint<bits_for(spec::kMaxColumns / kLanes)>;  // of a line
using TablePlace = Uint<kGroupIndexBits + 4>;                      // {bank, section, column}
using PastWord = Uint<kLanes * kPastFrames>;

class VerdictShell : public sc_core::sc_module {
 public:
  sc_core::sc_in<bool> clk_i{"clk_i"};
  sc_core::sc_in<bool> rst_i{"rst_i"};

  // A word of the registers is written; switches of the registers
  sc_core::sc_in<bool> write_i{"write_i"};
  sc_core::sc_in<bool> hold_i{"hold_i"};
  sc_core::sc_in<bool> by_encoder_i{"by_encoder_i"};

  // A frame
  sc_core::sc_in<bool> frame_i{"frame_i"};
  sc_core::sc_in<bool> restart_i{"restart_i"};
  sc_core::sc_in<VerdictCount> encoder_i{"encoder_i"};
  sc_core::sc_in<VerdictGroups> groups_i{"groups_i"};
  sc_core::sc_in<bool> grey_i{"grey_i"};
  sc_core::sc_out<bool> start_o{"start_o"};
  sc_core::sc_out<bool> ready_o{"ready_o"};
  sc_core::sc_in<bool> beat_valid_i{"beat_valid_i"};
  sc_core::sc_in<WideUint<128>> beat_data_i{"beat_data_i"};
  sc_core::sc_in<bool> break_i{"break_i"};

  // Its verdict
  sc_core::sc_out<bool> verdict_valid_o{"verdict_valid_o"};
  sc_core::sc_out<bool> in_part_o{"in_part_o"};
  sc_core::sc_out<bool> defect_o{"defect_o"};
  sc_core::sc_out<bool> lacks_light_o{"lacks_light_o"};
  sc_core::sc_out<VerdictColumns> first_column_o{"first_column_o"};
  sc_core::sc_out<VerdictColumns> columns_o{"columns_o"};
  sc_core::sc_out<VerdictColumns> unlit_o{"unlit_o"};
  sc_core::sc_out<bool> section_o{"section_o"};
  sc_core::sc_out<Uint<16>> part_o{"part_o"};
  sc_core::sc_out<VerdictCount> count_o{"count_o"};
  sc_core::sc_out<bool> bank_o{"bank_o"};
  sc_core::sc_out<bool> first_bad_o{"first_bad_o"};
  sc_core::sc_out<bool> passes_o{"passes_o"};
  sc_core::sc_out<VerdictWord> word_o{"word_o"};

  // Memory of the words
  sc_core::sc_out<bool> words_rd_en_o{"words_rd_en_o"};
  sc_core::sc_out<VerdictPlace> words_rd_addr_o{"words_rd_addr_o"};
  sc_core::sc_in<VerdictWord> words_rd_data_i{"words_rd_data_i"};
  // The table, read in every clock
  sc_core::sc_out<TablePlace> table_rd_addr_o{"table_rd_addr_o"};
  sc_core::sc_in<LimitsWord> table_rd_data_i{"table_rd_data_i"};
  // The limits of the frame, one memory for each lane, read in every clock
  sc_core::sc_out<Group> limits_rd_addr_o{"limits_rd_addr_o"};
  sc_core::sc_in<LimitsWord> limits_rd0_i{"limits_rd0_i"};
  sc_core::sc_in<LimitsWord> limits_rd1_i{"limits_rd1_i"};
  sc_core::sc_in<LimitsWord> limits_rd2_i{"limits_rd2_i"};
  sc_core::sc_in<LimitsWord> limits_rd3_i{"limits_rd3_i"};
  sc_core::sc_out<Uint<kLanes>> limits_wr_en_o{"limits_wr_en_o"};
  sc_core::sc_out<Group> limits_wr_addr_o{"limits_wr_addr_o"};
  sc_core::sc_out<LimitsWord> limits_wr_data_o{"limits_wr_data_o"};
  // What columns were in the last frames, read in every clock
  sc_core::sc_out<Group> past_rd_addr_o{"past_rd_addr_o"};
  sc_core::sc_in<PastWord> past_rd_data_i{"past_rd_data_i"};
  sc_core::sc_out<bool> past_wr_en_o{"past_wr_en_o"};
  sc_core::sc_out<Group> past_wr_addr_o{"past_wr_addr_o"};
  sc_core::sc_out<PastWord> past_wr_data_o{"past_wr_data_o"};

  SC_HAS_PROCESS(VerdictShell);
  explicit VerdictShell(const sc_core::sc_module_name& name) : sc_module(name) {
    SC_CTHREAD(clocked, clk_i.pos());
    reset_signal_is(rst_i, true);
    SC_METHOD(read_words);
    sensitive << write_i;
  }

 private:
  // Clocks from the last beat of a frame until its defects are found
  static constexpr int kDone = 14;

  void read_words() { words_rd_en_o.write(!write_i.read()); }

  // --- Registers ---
  VerdictParts parts_;
  // The limits of the frame
  bool composing_, ready_;
  Uint<kGroupIndexBits + 3> column_;  // whose word is read; the four behind the last one empty the pipeline
  Uint<kGroupIndexBits + 3> columns_of_line_;
  bool there_;                          // the table has the word that is there now
  Uint<kGroupIndexBits + 3> composed_;  // whose it is
  bool put_;                            // the frame has this column
  Uint<kLanes> put_lane_;
  Group put_group_;
  LimitsWord put_word_;
  // Beats, stages 1 to 3
  bool open_;  // a frame has begun and is not over
  bool break_;
  bool half_;  // the second two columns of a group come
  VerdictGroups beat_group_;
  Group read_group_;
  bool valid_[3];
  bool grey_[3];
  bool second_[3];
  WideUint<128> data_[3];
  LimitsWord limits_[kLanes];  // of the beat in stage 3
  // Columns of a beat with their products, stage 4
  bool came_[kLanes];
  bool group_end_;
  VerdictM1 m1_[kLanes];
  VerdictProduct least_[kLanes];
  VerdictProduct most_[kLanes];
  bool judged_[kLanes];
  bool column_lit_[kLanes];
  // A group of columns, stages 5 to 7
  Uint<4> state_[kLanes];
  bool group_valid_[3];
  Group group_;  // of the next one
  Group past_group_[2];
  Uint<kLanes> out_;
  Uint<kLanes> enough_;  // columns with enough hits
  // Defects
  VerdictColumns run_, at_;  // columns with enough hits directly before the next one, which is at_
  bool found_defect_;
  VerdictColumns first_column_, columns_, unlit_, lit_;
  bool past_put_;
  Group past_put_group_;
  PastWord past_;
  bool done_[kDone];
  bool whole_;
  // The verdict
  bool verdict_valid_, first_bad_, bad_before_;
  bool in_part_, defect_, lacks_light_;

  void reset() {
    parts_.reset();
    composing_ = false;
    ready_ = false;
    column_ = 0;
    columns_of_line_ = 0;
    there_ = false;
    composed_ = 0;
    put_ = false;
    put_lane_ = 0;
    put_group_ = 0;
    put_word_ = 0;
    open_ = false;
    break_ = false;
    half_ = false;
    beat_group_ = 0;
    read_group_ = 0;
    for (int i = 0; i < 3; ++i) {
      valid_[i] = false;
      grey_[i] = false;
      second_[i] = false;
      data_[i] = 0;
      group_valid_[i] = false;
    }
    for (int i = 0; i < 2; ++i) {
      past_group_[i] = 0;
    }
    group_end_ = false;
    enough_ = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      limits_[lane] = 0;
      came_[lane] = false;
      m1_[lane] = 0;
      least_[lane] = 0;
      most_[lane] = 0;
      judged_[lane] = false;
      column_lit_[lane] = false;
      state_[lane] = 0;
    }
    group_ = 0;
    out_ = 0;
    run_ = 0;
    at_ = 0;
    found_defect_ = false;
    first_column_ = 0;
    columns_ = 0;
    unlit_ = 0;
    lit_ = 0;
    past_put_ = false;
    past_put_group_ = 0;
    past_ = 0;
    for (int i = 0; i < kDone; ++i) {
      done_[i] = false;
    }
    whole_ = false;
    verdict_valid_ = false;
    first_bad_ = false;
    bad_before_ = false;
    in_part_ = false;
    defect_ = false;
    lacks_light_ = false;
  }

  void clocked() {
    reset();
    show_reset();
    wait();
    while (true) {
      // From the exit to the entry, so that each step sees the registers before it as they were in the clock that ends.
      bool found = done_[kDone - 1];
      bool whole = whole_;
      Uint<12> lit = lit_;
      decide();
      find_defects();
      mark();
      judge();
      multiply();
      enter();
      compose();
      if (parts_.start) {
        begin();
      }
      bool write = write_i.read();
      bool hold = hold_i.read();
      bool by_encoder = by_encoder_i.read();
      bool frame = frame_i.read();
      bool restart = restart_i.read();
      VerdictCount encoder = encoder_i.read();
      VerdictWord word = words_rd_data_i.read();
      parts_.step(write, hold, by_encoder, frame, restart, encoder, found, whole, lit, word);
      show();
      wait();
    }
  }

  // The verdict of a frame.
  void decide() {
    const bool found = done_[kDone - 1];
    const Uint<12> most = parts_.defect >> spec::kRegVerdictDefectMostUnlitLsb;
    const bool lacks_light = parts_.in_part && unlit_ > most;
    const bool bad = (parts_.in_part && found_defect_) || lacks_light;
    verdict_valid_ = found;
    first_bad_ = found && bad && !bad_before_;
    if (parts_.start && parts_.first) {
      bad_before_ = false;
    }
    if (found) {
      bad_before_ = bad_before_ || bad;
      in_part_ = parts_.in_part;
      defect_ = parts_.in_part && found_defect_;
      lacks_light_ = lacks_light;
    }
  }

  // Stage 7: defects among the columns with enough hits. In a group of which not all have enough, a run that came from
  // the left ends behind `lead` columns; another one may begin and end in it; a third one may leave it.
  void find_defects() {
    if (group_valid_[2]) {
      Uint<3> run = 0;  // columns of the group with enough hits directly before the next one
      bool all = true;  // so far
      Uint<3> lead = 0;
      Uint<3> inner = 0;
      Uint<3> inner_end = 0;
      for (int lane = 0; lane < kLanes; ++lane) {
        if (((enough_ >> lane) & 1) != 0) {
          run = run + 1;
        } else {
          if (all) {
            lead = run;
          } else if (run != 0) {
            inner = run;
            inner_end = lane;
          }
          all = false;
          run = 0;
        }
      }
      if (all) {
        run_ = run_ + kLanes;
      } else {
        VerdictColumns length = run_ + lead;
        VerdictColumns end = at_ + lead;
        end_run(length, end);
        length = inner;
        end = at_ + inner_end;
        end_run(length, end);
        run_ = run;
      }
      at_ = at_ + kLanes;
    }
    if (done_[6]) {  // with the last group, or behind it
      end_run(run_, at_);
      run_ = 0;
    }
  }

  // A run of columns with enough hits ends before `end`: the first one that is long enough is the defect.
  void end_run(const VerdictColumns& run, const VerdictColumns& end) {
    const Uint<8> width = parts_.defect >> spec::kRegVerdictDefectWidthLsb;
    if (!found_defect_ && run >= width) {
      found_defect_ = true;
      first_column_ = end + 1 - run;
      columns_ = run;
    }
  }

  // Stage 6: hits of the last frames.
  void mark() {
    past_put_ = group_valid_[1];
    past_put_group_ = past_group_[1];
    group_valid_[2] = group_valid_[1];
    PastWord past = past_rd_data_i.read();
    Uint<3> history = parts_.defect >> spec::kRegVerdictDefectHistoryLsb;
    const Uint<4> wanted = parts_.defect >> spec::kRegVerdictDefectHitsLsb;
    past_ = 0;
    enough_ = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      Past of_column = past >> (kPastFrames * lane);
      Past seen = 0;
      if (!parts_.fresh && parts_.in_part) {
        seen = counted(of_column, history);
      }
      const bool out = ((out_ >> lane) & 1) != 0;
      Uint<4> hits = hits_of(seen, out);
      Past kept = seen << 1;
      if (out) {
        kept = kept | 1;
      }
      past_ = past_ | (PastWord(kept) << (kPastFrames * lane));
      if (hits >= wanted) {
        enough_ = enough_ | (1 << lane);
      }
    }
  }

  // Stages 5 and 4: groups, and states of columns.
  void judge() {
    const bool above = parts_.in_part && ((parts_.defect >> spec::kRegVerdictDefectAboveLsb) & 1) != 0;
    const bool below = parts_.in_part && ((parts_.defect >> spec::kRegVerdictDefectBelowLsb) & 1) != 0;
    group_valid_[1] = group_valid_[0];
    past_group_[1] = past_group_[0];
    if (group_valid_[0]) {
      out_ = 0;
      Uint<3> unlit = 0;
      Uint<3> lit = 0;
      for (int lane = 0; lane < kLanes; ++lane) {
        const Uint<4> state = state_[lane];
        if ((above && (state & 1) != 0) || (below && (state & 2) != 0)) {
          out_ = out_ | (1 << lane);
        }
        if (parts_.in_part && (state & 4) != 0) {
          unlit = unlit + 1;
        }
        if ((state & 8) != 0) {
          lit = lit + 1;
        }
      }
      unlit_ = unlit_ + unlit;
      lit_ = lit_ + lit;
    }
    group_valid_[0] = group_end_;
    if (group_end_) {
      past_group_[0] = group_;
      group_ = group_ + 1;
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      if (came_[lane]) {
        VerdictM1 m1 = m1_[lane];
        VerdictProduct least = least_[lane];
        VerdictProduct most = most_[lane];
        state_[lane] = state_of(m1, least, most, judged_[lane], column_lit_[lane]);
      }
    }
  }

  // Stage 3: the moments of a beat, and the limits of their columns.
  void multiply() {
    group_end_ = valid_[2] && (!grey_[2] || second_[2]);
    for (int lane = 0; lane < kLanes; ++lane) {
      VerdictM0 m0 = 0;
      if (grey_[2]) {
        const Uint<64> word = data_[2].range(64 * (lane % 2) + 63, 64 * (lane % 2)).to_uint64();
        m0 = word >> spec::kGreyM0Lsb;
        m1_[lane] = word >> spec::kGreyM1Lsb;
      } else {
        const Uint<32> word = data_[2].range(32 * lane + 31, 32 * lane).to_uint();
        m0 = (word >> spec::kBinaryRunM0Lsb) & ((1 << spec::kBinaryRunM0Bits) - 1);
        m1_[lane] = (word >> spec::kBinaryRunM1Lsb) & ((1 << spec::kBinaryRunM1Bits) - 1);
      }
      LimitsWord of_column = limits_[lane];
      came_[lane] = valid_[2] && (!grey_[2] || second_[2] == (lane > 1));
      least_[lane] = least_of(m0, of_column);
      most_[lane] = most_of(m0, of_column);
      judged_[lane] = (of_column >> (2 * kLimitBits)) != 0;
      column_lit_[lane] = m0 != 0;
    }
  }

  // Beats, stages 2 and 1, and where the frame ends.
  void enter() {
    const bool grey = grey_i.read();
    const bool valid = beat_valid_i.read();
    const bool group_end = valid && (!grey || half_);
    const bool last = group_end && ((beat_group_ + 1) << kLaneBits) == columns_of_line_;
    limits_[0] = limits_rd0_i.read();
    limits_[1] = limits_rd1_i.read();
    limits_[2] = limits_rd2_i.read();
    limits_[3] = limits_rd3_i.read();
    for (int i = 2; i > 0; --i) {
      valid_[i] = valid_[i - 1];
      grey_[i] = grey_[i - 1];
      second_[i] = second_[i - 1];
      data_[i] = data_[i - 1];
    }
    valid_[0] = valid;
    grey_[0] = grey;
    second_[0] = half_;
    data_[0] = beat_data_i.read();
    read_group_ = beat_group_;
    for (int i = kDone - 1; i > 0; --i) {
      done_[i] = done_[i - 1];
    }
    done_[0] = false;
    if (parts_.start) {
      open_ = false;
    } else if (ready_) {
      open_ = true;
    } else if (last) {
      open_ = false;
      done_[0] = true;
      whole_ = true;
    } else if (open_ && break_) {
      open_ = false;
      done_[0] = true;
      whole_ = false;
    }
    // A break in the clock of the last beat comes too late.
    break_ = break_i.read();
    if (group_end) {
      beat_group_ = beat_group_ + 1;
    }
    if (valid) {
      half_ = grey && !half_;
    }
  }

  // The limits of the frame, one column a clock: the place of a word, the word, and its limits moved.
  void compose() {
    LimitsWord word = table_rd_data_i.read();
    const RowShift back = parts_.shift >> spec::kRegVerdictShiftRowsLsb;
    put_ = composed_ < columns_of_line_;
    put_lane_ = 1 << (composed_ & (kLanes - 1));
    put_group_ = composed_ >> kLaneBits;
    put_word_ = moved_limits(word, there_, back);
    composed_ = column_;
    const Uint<kGroupIndexBits + 4> place = place_of_column();
    there_ = place < spec::kMaxColumns;
    ready_ = composing_ && column_ == columns_of_line_ + 3;
    if (ready_) {
      composing_ = false;
    }
    column_ = column_ + 1;
    if (!composing_) {
      column_ = columns_of_line_ + 4;
    }
  }

  // Column less s, in two's complement: what is below 0 is beyond the last one.
  Uint<kGroupIndexBits + 4> place_of_column() const {
    const Uint<kShiftColumnsBits> s = parts_.shift >> spec::kRegVerdictShiftColumnsLsb;
    Uint<kGroupIndexBits + 4> place = column_ - s;
    if ((s >> (kShiftColumnsBits - 1)) != 0) {
      place = place + (1 << kShiftColumnsBits);
    }
    return place;
  }

  // A frame begins: it takes the place of one whose limits are not yet composed.
  void begin() {
    composing_ = true;
    ready_ = false;
    column_ = 0;
    const VerdictGroups groups = groups_i.read();
    columns_of_line_ = groups << kLaneBits;
    half_ = false;
    beat_group_ = 0;
    group_ = 0;
    run_ = 0;
    at_ = 0;
    found_defect_ = false;
    first_column_ = 0;
    columns_ = 0;
    unlit_ = 0;
    lit_ = 0;
  }

  // The outputs of a reset: see show_reset_common() of MomentsPorts.
  void show_reset() {
    start_o.write(false);
    ready_o.write(false);
    verdict_valid_o.write(false);
    in_part_o.write(false);
    defect_o.write(false);
    lacks_light_o.write(false);
    first_column_o.write(0);
    columns_o.write(0);
    unlit_o.write(0);
    section_o.write(false);
    part_o.write(0);
    count_o.write(0);
    bank_o.write(false);
    first_bad_o.write(false);
    passes_o.write(false);
    word_o.write(0);
    words_rd_addr_o.write(kDelayPlace);
    table_rd_addr_o.write(0);
    limits_rd_addr_o.write(0);
    limits_wr_en_o.write(0);
    limits_wr_addr_o.write(0);
    limits_wr_data_o.write(0);
    past_rd_addr_o.write(0);
    past_wr_en_o.write(false);
    past_wr_addr_o.write(0);
    past_wr_data_o.write(0);
  }

  // The outputs of the clock that begins.
  void show() {
    start_o.write(parts_.start);
    ready_o.write(ready_);
    verdict_valid_o.write(verdict_valid_);
    in_part_o.write(in_part_);
    defect_o.write(defect_);
    lacks_light_o.write(lacks_light_);
    first_column_o.write(first_column_);
    columns_o.write(columns_);
    unlit_o.write(unlit_);
    section_o.write(parts_.section);
    part_o.write(parts_.part);
    count_o.write(parts_.count);
    const Uint<1> bank = parts_.bank();
    bank_o.write(bank != 0);
    first_bad_o.write(first_bad_);
    passes_o.write(parts_.in_part);
    word_o.write(parts_.word);
    VerdictPlace place = parts_.address();
    words_rd_addr_o.write(place);
    TablePlace table = place_of_column();
    table = table & ((1 << (kGroupIndexBits + 2)) - 1);
    if (parts_.section) {
      table = table | (1 << (kGroupIndexBits + 2));
    }
    if (bank != 0) {
      table = table | (1 << (kGroupIndexBits + 3));
    }
    table_rd_addr_o.write(table);
    limits_rd_addr_o.write(read_group_);
    Uint<kLanes> lanes = 0;
    if (put_) {
      lanes = put_lane_;
    }
    limits_wr_en_o.write(lanes);
    limits_wr_addr_o.write(put_group_);
    limits_wr_data_o.write(put_word_);
    past_rd_addr_o.write(past_group_[0]);
    past_wr_en_o.write(past_put_);
    past_wr_addr_o.write(past_put_group_);
    past_wr_data_o.write(past_);
  }
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_VERDICT_SHELL_H
