// The drain of ColumnRunsShell. The last row of a frame waits in a line buffer. The drain reads it group by group, ends
// the open runs, and completes and sends half of its columns in each clock.
#ifndef SELFPROJ_HLS_SHELLS_RUNS_DRAIN_H
#define SELFPROJ_HLS_SHELLS_RUNS_DRAIN_H

#include "hls/shells/drain_order.h"
#include "hls/shells/runs_sums.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

template <typename F>
struct RunsDrain {
  static constexpr int kStages = 12;  // from the completion of columns to their exit
  DrainOrder<F> order;
  // Of the row that is drained
  Row rows;
  bool grey, strongest;
  // Stage 2: the columns of a group
  bool d2_first, d2_second;
  EndedRuns<F> d2_runs[F::kLanes];
  // Stages 3 to 14: half of the columns of a group, and whether they are the second half; the break
  bool d_valid[kStages];
  bool d_second[kStages];
  Uint<64> d_word[kStages][F::kHalf];
  bool d_break[kStages + 1];
  Uint<64> first_half[F::kHalf / 2];  // mode binary, stage 15: the first half of the group, two columns a word

  void reset() {
    order.reset();
    rows = 0;
    grey = false;
    strongest = false;
    d2_first = false;
    d2_second = false;
    for (int lane = 0; lane < F::kLanes; ++lane) {
      d2_runs[lane].clear();
    }
    for (int i = 0; i < kStages; ++i) {
      d_valid[i] = false;
      d_second[i] = false;
      for (int k = 0; k < F::kHalf; ++k) {
        d_word[i][k] = 0;
      }
    }
    for (int i = 0; i <= kStages; ++i) {
      d_break[i] = false;
    }
    for (int k = 0; k < F::kHalf / 2; ++k) {
      first_half[k] = 0;
    }
  }

  // The word of a column, in mode binary in the lower half.
  Uint<64> word_of(const EndedRuns<F>& run) const {
    typename F::Sum1 m1 = finished_m1<F>(run.row, run.m0, 0, run.a);
    Uint<2> runs = 0;
    Uint<5> second = 0;
    if (strongest) {
      runs = run.runs;
      second = ratio_of<F>(run.second, run.m0);
    }
    Uint<64> word = grey_word<F>(run.m0, m1, run.n);
    if (!grey) {
      Uint<spec::kBinaryWordBits> binary_moments = binary_word<F>(run.m0, m1);
      word = binary_run_word(binary_moments, runs, second);
    } else if (strongest) {
      word = grey_run_word<F>(run.m0, m1, run.n, runs, second);
    }
    return word;
  }

  // Updates stages 15 to 2 at the end of a clock. `line` is the output of the line buffer.
  void finish_words(const RunsRead<F>& read, const RunsSums<F>& sums, typename F::Pixels line) {
    for (int k = 0; k < F::kHalf / 2; ++k) {
      first_half[k] = two_columns(k);
    }
    for (int i = kStages - 1; i > 0; --i) {
      d_valid[i] = d_valid[i - 1];
      d_second[i] = d_second[i - 1];
      for (int k = 0; k < F::kHalf; ++k) {
        d_word[i][k] = d_word[i - 1][k];
      }
    }
    d_valid[0] = d2_first || d2_second;
    d_second[0] = d2_second;
    if (d2_first || d2_second) {
      for (int i = 0; i < F::kHalf; ++i) {
        EndedRuns<F> run = d2_runs[i + F::kHalf];
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
      for (int lane = 0; lane < F::kLanes; ++lane) {
        take(lane, read, sums, line);
      }
    }
    d2_second = d2_first;
    d2_first = order.odd;
  }

  // The last row ends the open run of a column.
  void take(int lane, const RunsRead<F>& read, const RunsSums<F>& sums, typename F::Pixels line) {
    OpenRun<F> run;
    EndedRuns<F> ended;
    run.clear();
    ended.clear();
    if (rows != 1) {
      run = sums.open_of(lane, order.s1_group, read);
      ended = sums.ended_of(lane, order.s1_group, read);
    }
    typename F::Pixel weight = lane_of<F>(line, lane);
    bool ends = false;
    OpenRun<F> complete = next_run<F>(run, weight, false, 0, ends);
    EndedRuns<F> all = next_ended<F>(ended, complete, rows);
    if (!complete.open) {
      all = ended;
    }
    d2_runs[lane] = all;
  }

  // Updates the line buffer and its reads at the end of a clock, after finish_words. `drain`: a group was requested.
  // `push`: `beat` goes into the line buffer. `broken`: the frame of `beat` breaks.
  void step(bool drain, bool push, bool broken, const RunsBeat<F>& beat) {
    order.step(drain, push, beat.line_end, broken);
    if (push) {
      rows = beat.row;
      grey = beat.grey;
      strongest = beat.strongest;
    }
  }

  // Mode binary: the columns 2 k and 2 k + 1 of those in the last stage
  Uint<64> two_columns(int k) const {
    Uint<64> columns = (d_word[kStages - 1][2 * k + 1] << spec::kBinaryRunWordBits) | d_word[kStages - 1][2 * k];
    return columns;
  }

  // --- The exit, in a clock: all columns of a group in mode binary, half of them in the grey modes, 64 bits at a time
  bool out_valid() const { return d_valid[kStages - 1] && (grey || d_second[kStages - 1]); }
  Uint<64> out(int i) const {
    Uint<64> word = d_word[kStages - 1][i];
    if (!grey) {
      if (i < F::kHalf / 2) {
        word = first_half[i];
      } else {
        word = two_columns(i - F::kHalf / 2);
      }
    }
    return word;
  }
};

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_SHELLS_RUNS_DRAIN_H
