// The drain of ColumnMomentsShell. In the grey modes the last row of a frame waits in a line buffer. The drain reads it
// group by group, and completes and sends two columns in each clock.
#ifndef SELFPROJ_HLS_SHELLS_MOMENTS_DRAIN_H
#define SELFPROJ_HLS_SHELLS_MOMENTS_DRAIN_H

#include "hls/shells/drain_order.h"
#include "hls/shells/moments_sums.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

struct MomentsDrain {
  DrainOrder order;
  Row rows;
  bool one_row, one_group;
  // Stages 2 and 3
  bool d2_break, d2_first, d2_valid, d3_pick;
  Sum0 d2_m0[kLanes];
  Row d2_n[kLanes];
  Pixels d2_weights;
  Sum1 d3_a[kLanes];
  Sum0 d3_old_m0[2];
  Sum0 d3_m0[2];
  Row d3_n[2];
  // Stages 3 to 11, and 4 to 11
  bool d_valid[9];
  bool d_break[9];
  Uint<64> d_word[8][2];

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
    for (int lane = 0; lane < kLanes; ++lane) {
      d2_m0[lane] = 0;
      d2_n[lane] = 0;
      d3_a[lane] = 0;
    }
    for (int i = 0; i < 2; ++i) {
      d3_old_m0[i] = 0;
      d3_m0[i] = 0;
      d3_n[i] = 0;
    }
    for (int i = 0; i < 9; ++i) {
      d_valid[i] = false;
      d_break[i] = false;
    }
    for (int i = 0; i < 8; ++i) {
      d_word[i][0] = 0;
      d_word[i][1] = 0;
    }
  }

  // Updates stages 11 to 3 at the end of a clock, two columns at a time. `line` is the output of the line buffer.
  void finish_words(const MomentsRead& read, const MomentsSums& sums, Pixels line) {
    for (int i = 7; i > 0; --i) {
      if (d_valid[i]) {
        d_word[i][0] = d_word[i - 1][0];
        d_word[i][1] = d_word[i - 1][1];
      }
    }
    for (int i = 0; i < 2; ++i) {
      if (d_valid[0]) {
        Sum1 a = d3_a[i + 2];
        if (d3_pick) {
          a = d3_a[i];
        }
        Sum1 m1 = finished_m1(rows, d3_m0[i], d3_old_m0[i], a);
        d_word[0][i] = grey_word(d3_m0[i], m1, d3_n[i]);
      }
      if (d2_valid) {
        Sum0 m0 = d2_m0[i + 2];
        Row n = d2_n[i + 2];
        Pixel weight = lane_of(d2_weights, i + 2);
        if (d2_first) {
          m0 = d2_m0[i];
          n = d2_n[i];
          weight = lane_of(d2_weights, i);
        }
        d3_old_m0[i] = m0;
        d3_m0[i] = next_m0(m0, weight);
        d3_n[i] = next_n(n, weight);
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
    for (int lane = 0; lane < kLanes; ++lane) {
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
  void step(bool drain, bool push, bool broken, const MomentsBeat& beat) {
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
