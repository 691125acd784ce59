// The runs of ColumnRunsShell: beats on their way, the memories' words of its columns, and the registers in which a
// beat is added to them.
#ifndef SELFPROJ_HLS_SHELLS_RUNS_SUMS_H
#define SELFPROJ_HLS_SHELLS_RUNS_SUMS_H

#include "hls/runs_arithmetic.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

// The memories' words: those of all columns of a beat, the first lowest
template <typename F>
struct RunsWords {
  static constexpr int kNBits = spec::kGreyNBits;                         // of a number of rows
  static constexpr int kOpenBits = 3 + kNBits + F::kM0Bits + F::kM1Bits;  // {N, M0, A, dark, open}
  static constexpr int kBestBits = 2 + 2 * F::kM0Bits;                    // {M0 of the second, M0, runs}
  static constexpr int kRestBits = 2 * kNBits + F::kM1Bits;               // {N, row, A}
  using Open = WideUint<F::kLanes * kOpenBits>;
  using Best = WideUint<F::kLanes * kBestBits>;
  using Rest = WideUint<F::kLanes * kRestBits>;
};

// The runs of a beat's columns, from the words that the memories show.
template <typename F>
struct RunsRead {
  using Words = RunsWords<F>;
  OpenRun<F> open[F::kLanes];
  EndedRuns<F> ended[F::kLanes];

  void take(const typename Words::Open& runs, const typename Words::Best& best, const typename Words::Rest& rest) {
    for (int lane = 0; lane < F::kLanes; ++lane) {
      Uint<1> is_open = part_of<1>(runs, Words::kOpenBits * lane);
      open[lane].open = is_open != 0;
      open[lane].dark = part_of<2>(runs, Words::kOpenBits * lane + 1);
      open[lane].a = part_of<F::kM1Bits>(runs, Words::kOpenBits * lane + 3);
      open[lane].m0 = part_of<F::kM0Bits>(runs, Words::kOpenBits * lane + 3 + F::kM1Bits);
      open[lane].n = part_of<Words::kNBits>(runs, Words::kOpenBits * lane + 3 + F::kM1Bits + F::kM0Bits);
      ended[lane].runs = part_of<2>(best, Words::kBestBits * lane);
      ended[lane].m0 = part_of<F::kM0Bits>(best, Words::kBestBits * lane + 2);
      ended[lane].second = part_of<F::kM0Bits>(best, Words::kBestBits * lane + 2 + F::kM0Bits);
      ended[lane].a = part_of<F::kM1Bits>(rest, Words::kRestBits * lane);
      ended[lane].row = part_of<Words::kNBits>(rest, Words::kRestBits * lane + F::kM1Bits);
      ended[lane].n = part_of<Words::kNBits>(rest, Words::kRestBits * lane + F::kM1Bits + Words::kNBits);
    }
  }
};

// A beat with the weights of its pixels and its place, or none.
template <typename F>
struct RunsBeat {
  bool valid;
  typename F::Group group;
  Row row;
  bool first_row, last_row, line_end;
  bool grey, strongest;
  Uint<2> gap;
  typename F::Pixels weights;

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
template <typename F>
struct RunsSums {
  bool s1_add, s2_add, s3_add;
  RunsBeat<F> s1_beat;
  typename F::Group s2_group, s3_group;
  OpenRun<F> s2_open[F::kLanes];
  EndedRuns<F> s2_ended[F::kLanes];
  OpenRun<F> s3_open[F::kLanes];
  EndedRuns<F> s3_ended[F::kLanes];

  void reset() {
    s1_add = false;
    s2_add = false;
    s3_add = false;
    s1_beat.reset();
    s2_group = 0;
    s3_group = 0;
    for (int lane = 0; lane < F::kLanes; ++lane) {
      s2_open[lane].clear();
      s2_ended[lane].clear();
      s3_open[lane].clear();
      s3_ended[lane].clear();
    }
  }

  // The runs of a column of the group that was read one clock ago. What the memories do not have yet is in stage 2 or
  // 3.
  OpenRun<F> open_of(int lane, typename F::Group group, const RunsRead<F>& read) const {
    OpenRun<F> run = read.open[lane];
    if (s2_add && s2_group == group) {
      run = s2_open[lane];
    } else if (s3_add && s3_group == group) {
      run = s3_open[lane];
    }
    return run;
  }
  EndedRuns<F> ended_of(int lane, typename F::Group group, const RunsRead<F>& read) const {
    EndedRuns<F> ended = read.ended[lane];
    if (s2_add && s2_group == group) {
      ended = s2_ended[lane];
    } else if (s3_add && s3_group == group) {
      ended = s3_ended[lane];
    }
    return ended;
  }

  // The words to write: those of stage 2.
  typename RunsWords<F>::Open open_words() const {
    typename RunsWords<F>::Open words = 0;
    for (int lane = F::kLanes - 1; lane >= 0; --lane) {
      const OpenRun<F>& run = s2_open[lane];
      words = (words << RunsWords<F>::kNBits) | typename RunsWords<F>::Open(run.n);
      words = (words << F::kM0Bits) | typename RunsWords<F>::Open(run.m0);
      words = (words << F::kM1Bits) | typename RunsWords<F>::Open(run.a);
      Uint<3> state = run.dark;
      state = state << 1;
      if (run.open) {
        state = state | 1;
      }
      words = (words << 3) | typename RunsWords<F>::Open(state);
    }
    return words;
  }
  typename RunsWords<F>::Best best_words() const {
    typename RunsWords<F>::Best words = 0;
    for (int lane = F::kLanes - 1; lane >= 0; --lane) {
      const EndedRuns<F>& ended = s2_ended[lane];
      words = (words << F::kM0Bits) | typename RunsWords<F>::Best(ended.second);
      words = (words << F::kM0Bits) | typename RunsWords<F>::Best(ended.m0);
      words = (words << 2) | typename RunsWords<F>::Best(ended.runs);
    }
    return words;
  }
  typename RunsWords<F>::Rest rest_words() const {
    typename RunsWords<F>::Rest words = 0;
    for (int lane = F::kLanes - 1; lane >= 0; --lane) {
      const EndedRuns<F>& ended = s2_ended[lane];
      words = (words << RunsWords<F>::kNBits) | typename RunsWords<F>::Rest(ended.n);
      words = (words << RunsWords<F>::kNBits) | typename RunsWords<F>::Rest(ended.row);
      words = (words << F::kM1Bits) | typename RunsWords<F>::Rest(ended.a);
    }
    return words;
  }

  // The end of a clock. `add`: the addition of `beat` begins. `read`: what the memories show.
  void step(bool add, const RunsBeat<F>& beat, const RunsRead<F>& read) {
    for (int lane = 0; lane < F::kLanes; ++lane) {
      OpenRun<F> run;
      EndedRuns<F> ended;
      run.clear();
      ended.clear();
      if (!s1_beat.first_row) {
        run = open_of(lane, s1_beat.group, read);
        ended = ended_of(lane, s1_beat.group, read);
      }
      typename F::Pixel weight = lane_of<F>(s1_beat.weights, lane);
      bool ends = false;
      OpenRun<F> next = next_run<F>(run, weight, s1_beat.strongest, s1_beat.gap, ends);
      EndedRuns<F> next_all = next_ended<F>(ended, next, s1_beat.row);
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
