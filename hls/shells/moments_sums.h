// The sums of ColumnMomentsShell: beats on their way, the memories' words of its columns, and the registers in which a
// beat's weights are added to them.
#ifndef SELFPROJ_HLS_SHELLS_MOMENTS_SUMS_H
#define SELFPROJ_HLS_SHELLS_MOMENTS_SUMS_H

#include "hls/moments_arithmetic.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

// The memories' words: half of the lanes each, the first lowest
template <typename F>
struct MomentsWords {
  static constexpr int kMBits = F::kM0Bits + spec::kGreyNBits;  // of a lane: {N, M0}
  using M = AnyUint<F::kHalf * kMBits>;
  using A = AnyUint<F::kHalf * F::kM1Bits>;
};

// A beat with the weights of its pixels and its place, or none.
template <typename F>
struct MomentsBeat {
  bool valid;
  typename F::Group group;
  Row row;
  bool first_row, last_row, line_end;
  bool one_group, two_groups;  // a row has no more groups than that
  bool grey;
  typename F::Pixels weights;

  void reset() {
    valid = false;
    group = 0;
    row = 0;
    first_row = false;
    last_row = false;
    line_end = false;
    one_group = false;
    two_groups = false;
    grey = false;
    weights = 0;
  }

  // Whether it is a last row of a grey mode, which goes to the drain and not to the sums.
  bool drains() const { return valid && last_row && grey; }
};

// The sums of a beat's columns as the memories show them.
template <typename F>
struct MomentsRead {
  using Words = MomentsWords<F>;
  typename F::Sum0 m0[F::kLanes];
  Row n[F::kLanes];
  typename F::Sum1 a[F::kLanes];

  void take(const typename Words::M& m_low, const typename Words::M& m_high, const typename Words::A& a_low,
            const typename Words::A& a_high) {
    for (int lane = 0; lane < F::kHalf; ++lane) {
      m0[lane] = part_of<F::kM0Bits>(m_low, Words::kMBits * lane);
      n[lane] = part_of<spec::kGreyNBits>(m_low, Words::kMBits * lane + F::kM0Bits);
      a[lane] = part_of<F::kM1Bits>(a_low, F::kM1Bits * lane);
      m0[lane + F::kHalf] = part_of<F::kM0Bits>(m_high, Words::kMBits * lane);
      n[lane + F::kHalf] = part_of<spec::kGreyNBits>(m_high, Words::kMBits * lane + F::kM0Bits);
      a[lane + F::kHalf] = part_of<F::kM1Bits>(a_high, F::kM1Bits * lane);
    }
  }
};

// Stages 1 (read), 2 (M) and 3 (A) of the additions.
template <typename F>
struct MomentsSums {
  bool s1_add, s1_first, s1_one, s1_two, s1_grey;
  typename F::Group s1_group;
  typename F::Pixels s1_weights;
  Row s1_row;
  bool s2_add, s2_first, s2_use_sum, s2_forward, s2_grey;
  typename F::Group s2_group;
  Row s2_row;
  typename F::Pixel s2_weight[F::kLanes];
  typename F::Sum0 s2_old_m0[F::kLanes];
  Row s2_old_n[F::kLanes];
  bool s3_add, s3_use_sum;
  typename F::Group s3_group;
  typename F::Sum1 s3_addend[F::kLanes];
  typename F::Sum1 s3_old_a[F::kLanes];
  typename F::Sum0 sum_m0[F::kLanes];
  Row sum_n[F::kLanes];
  typename F::Sum1 sum_a[F::kLanes];
  // What the memories get in this clock, and the sums take over at its end: each addition is there once.
  typename F::Sum0 added_m0[F::kLanes];
  Row added_n[F::kLanes];
  typename F::Sum1 added_a[F::kLanes];

  void reset() {
    s1_add = false;
    s1_first = false;
    s1_one = false;
    s1_two = false;
    s1_grey = false;
    s1_group = 0;
    s1_weights = 0;
    s1_row = 0;
    s2_add = false;
    s2_first = false;
    s2_use_sum = false;
    s2_forward = false;
    s2_grey = false;
    s2_group = 0;
    s2_row = 0;
    s3_add = false;
    s3_use_sum = false;
    s3_group = 0;
    for (int lane = 0; lane < F::kLanes; ++lane) {
      s2_weight[lane] = 0;
      s2_old_m0[lane] = 0;
      s2_old_n[lane] = 0;
      s3_addend[lane] = 0;
      s3_old_a[lane] = 0;
      sum_m0[lane] = 0;
      sum_n[lane] = 0;
      sum_a[lane] = 0;
      added_m0[lane] = 0;
      added_n[lane] = 0;
      added_a[lane] = 0;
    }
  }

  // --- What follows from the registers in their clock ---
  typename F::Sum0 now_m0(int lane) const {
    typename F::Sum0 base = s2_old_m0[lane];
    if (s2_use_sum) {
      base = sum_m0[lane];
    }
    return base;
  }
  Row now_n(int lane) const {
    Row base = s2_old_n[lane];
    if (s2_use_sum) {
      base = sum_n[lane];
    }
    return base;
  }
  typename F::Sum1 now_a(int lane) const {
    typename F::Sum1 base = s3_old_a[lane];
    if (s3_use_sum) {
      base = sum_a[lane];
    }
    return base;
  }
  // The additions of the clock that begins.
  void add() {
    for (int lane = 0; lane < F::kLanes; ++lane) {
      typename F::Sum0 m0 = now_m0(lane);
      Row n = now_n(lane);
      typename F::Sum1 a = now_a(lane);
      added_m0[lane] = next_m0<F>(m0, s2_weight[lane]);
      added_n[lane] = next_n<F>(n, s2_weight[lane]);
      added_a[lane] = a + s3_addend[lane];
    }
  }
  // One lane of the word to write: {N, M0}.
  Uint<MomentsWords<F>::kMBits> word_m(int lane) const {
    Uint<MomentsWords<F>::kMBits> word = added_n[lane];
    word = (word << F::kM0Bits) | added_m0[lane];
    return word;
  }

  // The end of a clock. `add`: the addition of a beat begins. `read`: what the memories show.
  void step(bool add, const MomentsBeat<F>& beat, const MomentsRead<F>& read) {
    // The beat two clocks ahead had the same address, and its sum is not in the memory yet.
    const bool forward = s1_two && s2_add && s3_add;
    for (int lane = 0; lane < F::kLanes; ++lane) {
      step_lane(lane, forward, read);
    }
    s3_add = s2_add;
    if (s2_add) {
      s3_group = s2_group;
      s3_use_sum = s2_use_sum;
    }
    s2_add = s1_add;
    if (s1_add) {
      s2_group = s1_group;
      s2_first = s1_first;
      s2_use_sum = s1_one && !s1_first;
      s2_forward = forward;
      s2_grey = s1_grey;
      s2_row = s1_row;
    }
    s1_add = add;
    if (add) {
      s1_group = beat.group;
      s1_first = beat.first_row;
      s1_one = beat.one_group;
      s1_two = beat.two_groups;
      s1_grey = beat.grey;
      s1_weights = beat.weights;
      s1_row = beat.row;
    }
  }

  void step_lane(int lane, bool forward, const MomentsRead<F>& read) {
    typename F::Sum0 m0 = now_m0(lane);
    const typename F::Sum0 old_sum_m0 = sum_m0[lane];
    const Row old_sum_n = sum_n[lane];
    const typename F::Sum1 old_sum_a = sum_a[lane];
    if (s3_add) {
      sum_a[lane] = added_a[lane];
    }
    if (s2_add) {
      sum_m0[lane] = added_m0[lane];
      sum_n[lane] = added_n[lane];
      s3_addend[lane] = addend_of<F>(m0, s2_weight[lane], s2_row, s2_grey);
      s3_old_a[lane] = read.a[lane];
      if (s2_first) {
        s3_old_a[lane] = 0;
      } else if (s2_forward) {
        s3_old_a[lane] = old_sum_a;
      }
    }
    if (s1_add) {
      s2_weight[lane] = lane_of<F>(s1_weights, lane);
      s2_old_m0[lane] = read.m0[lane];
      s2_old_n[lane] = read.n[lane];
      if (s1_first) {
        s2_old_m0[lane] = 0;
        s2_old_n[lane] = 0;
      } else if (forward) {
        s2_old_m0[lane] = old_sum_m0;
        s2_old_n[lane] = old_sum_n;
      }
    }
  }
};

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_SHELLS_MOMENTS_SUMS_H
