// The drain of ColumnRunsShell. The last row of a frame waits in a line buffer. The drain reads it group by group, ends
// the open runs, and completes and sends two columns in each clock.
#ifndef SELFPROJ_HLS_SHELLS_RUNS_DRAIN_H
#define SELFPROJ_HLS_SHELLS_RUNS_DRAIN_H

#include "hls/shells/drain_order.h"
#include "hls/shells/runs_sums.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

struct RunsDrain {
  static constexpr int kStages = 12;  // from the completion of two columns to their exit
  DrainOrder order;
  // Of the row that is drained
  Row rows;
  bool grey, strongest;
  // Stage 2: the columns of a group
  bool d2_first, d2_second;
  EndedRuns d2_runs[kLanes];
  // Stages 3 to 14: two columns, and whether they are the second two of their group; the break
  bool d_valid[kStages];
  bool d_second[kStages];
  Uint<64> d_word[kStages][2];
  bool d_break[kStages + 1];
  Uint<64> first_pair;  // mode binary, stage 15: the first two columns of the group

  void reset() {
    order.reset();
    rows = 0;
    grey = false;
    strongest = false;
    d2_first = false;
    d2_second = false;
    for (int lane = 0; lane < kLanes; ++lane) {
      d2_runs[lane].clear();
    }
    for (int i = 0; i < kStages; ++i) {
      d_valid[i] = false;
      d_second[i] = false;
      d_word[i][0] = 0;
      d_word[i][1] = 0;
    }
    for (int i = 0; i <= kStages; ++i) {
      d_break[i] = false;
    }
    first_pair = 0;
  }

  // The word of a column, in mode binary in the lower half.
  Uint<64> word_of(const EndedRuns& run) const {
    Sum1 m1 = finished_m1(run.row, run.m0, 0, run.a);
    Uint<2> runs = 0;
    Uint<5> second = 0;
    if (strongest) {
      runs = run.runs;
      second = ratio_of(run.second, run.m0);
    }
    Uint<spec::kGreyWordBits> grey_moments = grey_word(run.m0, m1, run.n);
    Uint<spec::kBinaryWordBits> binary_moments = binary_word(run.m0, m1);
    Uint<64> word = grey_run_word(grey_moments, runs, second);
    if (!grey) {
      word = binary_run_word(binary_moments, runs, second);
    }
    return word;
  }

  // Updates stages 15 to 2 at the end of a clock. `line` is the output of the line buffer.
  void finish_words(const RunsRead& read, const RunsSums& sums, Pixels line) {
    first_pair = (d_word[kStages - 1][1] << spec::kBinaryRunWordBits) | d_word[kStages - 1][0];
    for (int i = kStages - 1; i > 0; --i) {
      d_valid[i] = d_valid[i - 1];
      d_second[i] = d_second[i - 1];
      d_word[i][0] = d_word[i - 1][0];
      d_word[i][1] = d_word[i - 1][1];
    }
    d_valid[0] = d2_first || d2_second;
    d_second[0] = d2_second;
    if (d2_first || d2_second) {
      for (int i = 0; i < 2; ++i) {
        EndedRuns run = d2_runs[i + 2];
        if (d2_first) {
          run = d2_runs[i];
        }
        d_word[0][i] = word_of(run);
      }
    }
    for (int i = kStages; i > 0; --i) {
      d_break[i] = d_break[i - 1];
    }
    d_break[0] = order.broke;
    if (order.odd) {
      for (int lane = 0; lane < kLanes; ++lane) {
        take(lane, read, sums, line);
      }
    }
    d2_second = d2_first;
    d2_first = order.odd;
  }

  // The last row ends the open run of a column.
  void take(int lane, const RunsRead& read, const RunsSums& sums, Pixels line) {
    OpenRun run;
    EndedRuns ended;
    run.clear();
    ended.clear();
    if (rows != 1) {
      run = sums.open_of(lane, order.s1_group, read);
      ended = sums.ended_of(lane, order.s1_group, read);
    }
    Pixel weight = lane_of(line, lane);
    bool ends = false;
    OpenRun complete = next_run(run, weight, false, 0, ends);
    EndedRuns all = next_ended(ended, complete, rows);
    if (!complete.open) {
      all = ended;
    }
    d2_runs[lane] = all;
  }

  // Updates the line buffer and its reads at the end of a clock, after finish_words. `drain`: a group was requested.
  // `push`: `beat` goes into the line buffer. `broken`: the frame of `beat` breaks.
  void step(bool drain, bool push, bool broken, const RunsBeat& beat) {
    order.step(drain, push, beat.line_end, broken);
    if (push) {
      rows = beat.row;
      grey = beat.grey;
      strongest = beat.strongest;
    }
  }

  // --- The exit, in a clock: four columns in mode binary, two in the grey modes ---
  bool out_valid() const { return d_valid[kStages - 1] && (grey || d_second[kStages - 1]); }
  Uint<64> out_low() const {
    Uint<64> low = first_pair;
    if (grey) {
      low = d_word[kStages - 1][0];
    }
    return low;
  }
  Uint<64> out_high() const {
    Uint<64> high = (d_word[kStages - 1][1] << spec::kBinaryRunWordBits) | d_word[kStages - 1][0];
    if (grey) {
      high = d_word[kStages - 1][1];
    }
    return high;
  }
};

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_SHELLS_RUNS_DRAIN_H
