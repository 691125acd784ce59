// The drain of ColumnMomentsShell. In the grey modes the last row of a frame waits in a line buffer. The drain reads it
// group by group, and completes and sends half of its columns in each clock.
#ifndef SELFPROJ_HLS_SHELLS_MOMENTS_DRAIN_H
#define SELFPROJ_HLS_SHELLS_MOMENTS_DRAIN_H

#include "hls/shells/drain_order.h"
#include "hls/shells/moments_sums.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

template <typename F>
struct MomentsDrain {
  DrainOrder<F> order;
  Row rows;
  bool one_row, one_group;
  // Stages 2 and 3
  bool d2_break, d2_first, d2_valid, d3_pick;
  typename F::Sum0 d2_m0[F::kLanes];
  Row d2_n[F::kLanes];
  typename F::Pixels d2_weights;
  typename F::Sum1 d3_a[F::kLanes];
  typename F::Sum0 d3_old_m0[F::kHalf];
  typename F::Sum0 d3_m0[F::kHalf];
  Row d3_n[F::kHalf];
  // Stages 3 to 11, and 4 to 11
  bool d_valid[9];
  bool d_break[9];
  Uint<64> d_word[8][F::kHalf];

  void reset() {
    order.reset();
    rows = 0;
    one_row = false;
    one_group = false;
    d2_break = false;
    d2_first = false;
    d2_valid = false;
    d3_pick = false;
    d2_weights = 0;
    for (int lane = 0; lane < F::kLanes; ++lane) {
      d2_m0[lane] = 0;
      d2_n[lane] = 0;
      d3_a[lane] = 0;
    }
    for (int i = 0; i < F::kHalf; ++i) {
      d3_old_m0[i] = 0;
      d3_m0[i] = 0;
      d3_n[i] = 0;
    }
    for (int i = 0; i < 9; ++i) {
      d_valid[i] = false;
      d_break[i] = false;
    }
    for (int i = 0; i < 8; ++i) {
      for (int k = 0; k < F::kHalf; ++k) {
        d_word[i][k] = 0;
      }
    }
  }

  // Updates stages 11 to 3 at the end of a clock, half of a group at a time. `line` is the output of the line buffer.
  void finish_words(const MomentsRead<F>& read, const MomentsSums<F>& sums, typename F::Pixels line) {
    for (int i = 7; i > 0; --i) {
      if (d_valid[i]) {
        for (int k = 0; k < F::kHalf; ++k) {
          d_word[i][k] = d_word[i - 1][k];
        }
      }
    }
    for (int i = 0; i < F::kHalf; ++i) {
      if (d_valid[0]) {
        typename F::Sum1 a = d3_a[i + F::kHalf];
        if (d3_pick) {
          a = d3_a[i];
        }
        typename F::Sum1 m1 = finished_m1<F>(rows, d3_m0[i], d3_old_m0[i], a);
        d_word[0][i] = grey_word<F>(d3_m0[i], m1, d3_n[i]);
      }
      if (d2_valid) {
        typename F::Sum0 m0 = d2_m0[i + F::kHalf];
        Row n = d2_n[i + F::kHalf];
        typename F::Pixel weight = lane_of<F>(d2_weights, i + F::kHalf);
        if (d2_first) {
          m0 = d2_m0[i];
          n = d2_n[i];
          weight = lane_of<F>(d2_weights, i);
        }
        d3_old_m0[i] = m0;
        d3_m0[i] = next_m0<F>(m0, weight);
        d3_n[i] = next_n<F>(n, weight);
      }
    }
    for (int i = 8; i > 0; --i) {
      d_valid[i] = d_valid[i - 1];
      d_break[i] = d_break[i - 1];
    }
    d_valid[0] = d2_valid;
    d_break[0] = d2_break;
    d2_break = order.broke;
    d3_pick = d2_first;
    for (int lane = 0; lane < F::kLanes; ++lane) {
      if (d2_first) {
        d3_a[lane] = read.a[lane];
        if (one_row) {
          d3_a[lane] = 0;
        } else if (one_group) {
          d3_a[lane] = sums.sum_a[lane];
        }
      }
      if (order.odd) {
        d2_m0[lane] = read.m0[lane];
        d2_n[lane] = read.n[lane];
        if (one_row) {
          d2_m0[lane] = 0;
          d2_n[lane] = 0;
        } else if (one_group) {
          d2_m0[lane] = sums.sum_m0[lane];
          d2_n[lane] = sums.sum_n[lane];
        }
      }
    }
    if (order.odd) {
      d2_weights = line;
    }
    d2_valid = order.odd || d2_first;
    d2_first = order.odd;
  }

  // Updates the line buffer and its reads at the end of a clock, after finish_words. `drain`: a group was requested.
  // `push`: `beat` goes into the line buffer. `broken`: the frame of `beat` breaks.
  void step(bool drain, bool push, bool broken, const MomentsBeat<F>& beat) {
    order.step(drain, push, beat.line_end, broken);
    if (push) {
      rows = beat.row;
      one_row = beat.first_row;
      one_group = beat.one_group;
    }
  }
};

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_SHELLS_MOMENTS_DRAIN_H
