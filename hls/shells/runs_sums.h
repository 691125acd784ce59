// The runs of ColumnRunsShell: beats on their way, the memories' words of four columns, and the registers in which a
// beat is added to them.
#ifndef SELFPROJ_HLS_SHELLS_RUNS_SUMS_H
#define SELFPROJ_HLS_SHELLS_RUNS_SUMS_H

#include "hls/runs_arithmetic.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

// The words of a column
constexpr int kOpenBits = 3 + spec::kGreyNBits + spec::kGreyM0Bits + spec::kGreyM1Bits;  // {N, M0, A, dark, open}
constexpr int kBestBits = 2 + 2 * spec::kGreyM0Bits;                                     // {M0 of the second, M0, runs}
constexpr int kRestBits = 2 * spec::kGreyNBits + spec::kGreyM1Bits;                      // {N, row, A}

inline Uint<kOpenBits> open_word(const OpenRun& run) {
  Uint<kOpenBits> word = run.n;
  word = (word << spec::kGreyM0Bits) | run.m0;
  word = (word << spec::kGreyM1Bits) | run.a;
  word = (word << 2) | run.dark;
  word = word << 1;
  if (run.open) {
    word = word | 1;
  }
  return word;
}

inline Uint<kBestBits> best_word(const EndedRuns& ended) {
  Uint<kBestBits> word = ended.second;
  word = (word << spec::kGreyM0Bits) | ended.m0;
  word = (word << 2) | ended.runs;
  return word;
}

inline Uint<kRestBits> rest_word(const EndedRuns& ended) {
  Uint<kRestBits> word = ended.n;
  word = (word << spec::kGreyNBits) | ended.row;
  word = (word << spec::kGreyM1Bits) | ended.a;
  return word;
}

// The runs of four columns, from the words that the memories show.
struct RunsRead {
  OpenRun open[kLanes];
  EndedRuns ended[kLanes];

  void take(int lane, Uint<kOpenBits> word, Uint<kBestBits> best, Uint<kRestBits> rest) {
    Uint<1> is_open = word;
    open[lane].open = is_open != 0;
    open[lane].dark = word >> 1;
    open[lane].a = word >> 3;
    open[lane].m0 = word >> (3 + spec::kGreyM1Bits);
    open[lane].n = word >> (3 + spec::kGreyM1Bits + spec::kGreyM0Bits);
    ended[lane].runs = best;
    ended[lane].m0 = best >> 2;
    ended[lane].second = best >> (2 + spec::kGreyM0Bits);
    ended[lane].a = rest;
    ended[lane].row = rest >> spec::kGreyM1Bits;
    ended[lane].n = rest >> (spec::kGreyM1Bits + spec::kGreyNBits);
  }
};

// A beat with the weights of its pixels and its place, or none.
struct RunsBeat {
  bool valid;
  Group group;
  Row row;
  bool first_row, last_row, line_end;
  bool grey, strongest;
  Uint<2> gap;
  Pixels weights;

  void reset() {
    valid = false;
    group = 0;
    row = 0;
    first_row = false;
    last_row = false;
    line_end = false;
    grey = false;
    strongest = false;
    gap = 0;
    weights = 0;
  }

  // Whether it is of a last row, which goes to the drain and not to the runs.
  bool drains() const { return valid && last_row; }
};

// Stages 1 (read), 2 (write) and 3 (the memories have it one clock later) of the additions.
struct RunsSums {
  bool s1_add, s2_add, s3_add;
  RunsBeat s1_beat;
  Group s2_group, s3_group;
  OpenRun s2_open[kLanes];
  EndedRuns s2_ended[kLanes];
  OpenRun s3_open[kLanes];
  EndedRuns s3_ended[kLanes];

  void reset() {
    s1_add = false;
    s2_add = false;
    s3_add = false;
    s1_beat.reset();
    s2_group = 0;
    s3_group = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      s2_open[lane].clear();
      s2_ended[lane].clear();
      s3_open[lane].clear();
      s3_ended[lane].clear();
    }
  }

  // The runs of a column of the group that was read one clock ago. What the memories do not have yet is in stage 2 or
  // 3.
  OpenRun open_of(int lane, Group group, const RunsRead& read) const {
    OpenRun run = read.open[lane];
    if (s2_add && s2_group == group) {
      run = s2_open[lane];
    } else if (s3_add && s3_group == group) {
      run = s3_open[lane];
    }
    return run;
  }
  EndedRuns ended_of(int lane, Group group, const RunsRead& read) const {
    EndedRuns ended = read.ended[lane];
    if (s2_add && s2_group == group) {
      ended = s2_ended[lane];
    } else if (s3_add && s3_group == group) {
      ended = s3_ended[lane];
    }
    return ended;
  }

  // The end of a clock. `add`: the addition of `beat` begins. `read`: what the memories show.
  void step(bool add, const RunsBeat& beat, const RunsRead& read) {
    for (int lane = 0; lane < kLanes; ++lane) {
      OpenRun run;
      EndedRuns ended;
      run.clear();
      ended.clear();
      if (!s1_beat.first_row) {
        run = open_of(lane, s1_beat.group, read);
        ended = ended_of(lane, s1_beat.group, read);
      }
      Pixel weight = lane_of(s1_beat.weights, lane);
      bool ends = false;
      OpenRun next = next_run(run, weight, s1_beat.strongest, s1_beat.gap, ends);
      EndedRuns next_all = next_ended(ended, next, s1_beat.row);
      if (!ends) {
        next_all = ended;
      }
      s3_open[lane] = s2_open[lane];
      s3_ended[lane] = s2_ended[lane];
      s2_open[lane] = next;
      s2_ended[lane] = next_all;
    }
    s3_add = s2_add;
    s3_group = s2_group;
    s2_add = s1_add;
    s2_group = s1_beat.group;
    s1_add = add;
    s1_beat = beat;
  }
};

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_SHELLS_RUNS_SUMS_H
