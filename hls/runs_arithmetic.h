// Pure functions of the strongest runs: operations on one run and on the runs of one column. The SystemC shell
// (hls/shells/column_runs_shell.h) uses them.
//
// Each column has an open run, the strongest of the runs that have ended, and M0 of the second. A run ends in the row
// in which it has had more dark rows than the gap allows. A run has M0, N, and A, the sum over the rows of M0 before
// each; in row R, in which it ends,
//
//     M1 = R M0 - A        with A of the rows before R.
#ifndef SELFPROJ_HLS_RUNS_ARITHMETIC_H
#define SELFPROJ_HLS_RUNS_ARITHMETIC_H

#include "hls/moments_arithmetic.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

// The open run of a column. (Its members have no initial values, nor has it a constructor: ICSC takes no array of such
// records.)
template <typename F>
struct OpenRun {
  bool open;
  Uint<2> dark;  // dark rows since the last lit one
  typename F::Sum0 m0;
  typename F::Sum1 a;  // of the rows before the present one
  Row n;

  // No run is open.
  void clear() {
    open = false;
    dark = 0;
    m0 = 0;
    a = 0;
    n = 0;
  }
};

// The runs of a column that have ended.
template <typename F>
struct EndedRuns {
  Uint<2> runs;             // 3: three or more
  typename F::Sum0 second;  // M0 of the second
  typename F::Sum0 m0;      // the strongest, and so on
  typename F::Sum1 a;
  Row n;
  Row row;  // the row in which it ended

  // None has ended.
  void clear() {
    runs = 0;
    second = 0;
    m0 = 0;
    a = 0;
    n = 0;
    row = 0;
  }
};

// A row is added to the open run; `ends`: the row, which is dark, ended it.
template <typename F>
inline OpenRun<F> next_run(const OpenRun<F>& old, typename F::Pixel weight, bool strongest, Uint<2> gap, bool& ends) {
  OpenRun<F> next;
  next.clear();
  ends = false;
  if (old.open) {
    next = old;
    next.a = old.a + old.m0;
  }
  if (weight != 0) {
    next.open = true;
    next.dark = 0;
    next.m0 = next_m0<F>(next.m0, weight);
    next.n = next_n<F>(next.n, weight);
  } else if (old.open) {
    ends = strongest && old.dark == gap;
    next.dark = old.dark + 1;
    next.open = !ends;
  }
  return next;
}

// `run` meets the strongest of the runs that ended before it, and the second.
template <typename F>
inline EndedRuns<F> next_ended(const EndedRuns<F>& old, const OpenRun<F>& run, Row row) {
  EndedRuns<F> next = old;
  if (old.runs != 3) {
    next.runs = old.runs + 1;
  }
  if (run.m0 > old.m0) {
    next.second = old.m0;
    next.m0 = run.m0;
    next.a = run.a;
    next.n = run.n;
    next.row = row;
  } else if (run.m0 > old.second) {
    next.second = run.m0;
  }
  return next;
}

// floor(16 second / m0) of second <= m0; 0 where both are 0.
template <typename F>
inline Uint<5> ratio_of(typename F::Sum0 second, typename F::Sum0 m0) {
  Uint<5> ratio = 0;
  Uint<F::kM0Bits + 1> rest = second;
  for (int bit = 4; bit >= 0; --bit) {
    ratio = ratio << 1;
    if (m0 != 0 && rest >= m0) {
      rest = rest - m0;
      ratio = ratio | 1;
    }
    rest = rest << 1;
  }
  return ratio;
}

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_RUNS_ARITHMETIC_H
