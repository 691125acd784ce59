// Column moments of a stream of frames, 4 pixels a step, as include/selfproj/model/column_moments.h specifies them, for
// HLS tools.
//
// Three layers:
//   moments_arithmetic.h  operations on one pixel, one sum, one word; the SystemC shell uses them, too
//   ColumnMoments         one step: a beat of 4 pixels in, at most 16 bytes of payload out; keeps the sums
//   moments_streams.h     one step of the streams: AXI4-Stream video in, payload out; column_moments_top() is one of
//   them
//
// A step is a clock: the tool pipelines it with an initiation interval of 1.
//
// The sums are those of docs/circuits/moments.md. In mode binary a lit pixel adds its row to A, which is M1. In the
// grey modes A adds up the M0 before each row. The last row waits in a line buffer, and as its columns leave, two a
// step,
//
//     M0 = M0' + v,   N = N' + [v > 0],   M1 = R M0 - (A + M0')
//
// where M0', N' and A hold after row R-1 and v is the last row's weight. One adder for each lane is thus enough, and
// the only multipliers are the two at the exit.
#ifndef SELFPROJ_HLS_COLUMN_MOMENTS_H
#define SELFPROJ_HLS_COLUMN_MOMENTS_H

#include "hls/last_row.h"
#include "hls/moments_arithmetic.h"
#include "hls/moments_streams.h"
#include "hls/recent.h"
#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
//   equals-default: the constructor holds pragmas
//   reserved-identifier, identifier-naming: for variables that clang itself makes to copy arrays of structs
// NOLINTBEGIN(performance-unnecessary-value-param,modernize-use-equals-default)
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
namespace selfproj {
namespace hls {

// Takes rows and columns up to the maxima of the specification.
//
// In mode binary, payload leaves with the step that brings its pixels. In the grey modes group g leaves at the earliest
// with the steps g + 1 and g + 2 after its pixels, two steps for each group. While draining(), only a first row that is
// not the last may come, and nothing for which exit_taken(). MomentsKernel ensures this. Between
// frames of one size it never has to wait.
class ColumnMoments {
 public:
  ColumnMoments() {
// The sums of the four lanes are one word of one memory: one read and one write a step.
#pragma HLS aggregate variable = sums_ compact = bit
#pragma HLS bind_storage variable = sums_ type = ram_s2p impl = bram
#pragma HLS bind_storage variable = line_ type = ram_s2p impl = bram
// All four lanes at once.
#pragma HLS array_partition variable = held_.m0 complete
#pragma HLS array_partition variable = held_.a complete
#pragma HLS array_partition variable = held_.n complete
  }

  // The last row of a grey frame has ended and is still being read.
  bool draining() const { return last_row_.draining(); }
  // Payload of such a frame leaves with the next step, so that of a beat in mode binary cannot.
  bool exit_taken(bool last_row, ModeBits mode) const {
    return last_row_.odd() && last_row && mode == spec::kModeBinary;
  }
  // The last row of a grey frame comes or leaves.
  bool busy() const { return last_row_.busy(); }

  MomentsOut step(const MomentsIn& in) {
#pragma HLS inline
// A word is read from the memory at the earliest kMemoryDistance steps after it was written; newer words come from the
// recent_ ones. The tool may therefore spread read, addition and write over several clocks and still begin a step in
// every clock.
#pragma HLS dependence variable = sums_ type = inter direction = RAW distance = 4 true
#pragma HLS dependence variable = line_ type = inter direction = RAW distance = 4 true
// The read of a drained group and the write of a first row may meet the same word in one step, but the write never
// comes first.
#pragma HLS dependence variable = sums_ type = inter direction = WAR false
    static_assert(kMemoryDistance == 4, "the distance in the pragma");
    const bool grey = in.mode != spec::kModeBinary;
    const bool push = in.valid && in.last_row && grey;
    const bool add = in.valid && !push;
    const bool drain = last_row_.drains();

    // One read: of the group that is added up, or of the one that leaves. A first row needs none.
    Group address = in.group;
    if (drain) {
      address = last_row_.group();
    }
    const Sums stored = sums_[static_cast<int>(address)];
    const Sums old = recent_.read(address, stored);

    const Pixels stored_weights = line_[static_cast<int>(last_row_.group())];
    MomentsOut out = leave(drain, old, recent_line_.read(last_row_.group(), stored_weights));
    if (add) {
      add_up(in, old, grey, out);
    }
    if (push) {
      const Pixels weights = weights_of(in.pixels, in.threshold, in.mode);
      line_[static_cast<int>(in.group)] = weights;
      recent_line_.write(in.group, weights);
      rows_ = in.row;
    }
    last_row_.step(push, push && in.line_end, in.broken, drain);
    return out;
  }

 private:
  static constexpr int kGroups = spec::kMaxColumns / kLanes;

  // The sums of four columns.
  struct Sums {
    Sum0 m0[kLanes];
    Sum1 a[kLanes];
    Row n[kLanes];
  };

  void add_up(const MomentsIn& in, const Sums& old, bool grey, MomentsOut& out) {
#pragma HLS inline
    Sums next;
    Uint<spec::kBinaryWordBits> words[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
#pragma HLS unroll
      Sum0 m0 = 0;
      Sum1 a = 0;
      Row n = 0;
      if (!in.first_row) {
        m0 = old.m0[lane];
        a = old.a[lane];
        n = old.n[lane];
      }
      const Pixel weight = weight_of(lane_of(in.pixels, lane), in.threshold, in.mode);
      next.m0[lane] = next_m0(m0, weight);
      next.a[lane] = a + addend_of(m0, weight, in.row, grey);
      next.n[lane] = next_n(n, weight);
      words[lane] = binary_word(next.m0[lane], next.a[lane]);
    }
    sums_[static_cast<int>(in.group)] = next;
    recent_.write(in.group, next);
    if (in.last_row) {  // in mode binary: the sums are complete
      Uint<64> low = words[1];
      Uint<64> high = words[3];
      out.valid = true;
      out.low = (low << spec::kBinaryWordBits) | words[0];
      out.high = (high << spec::kBinaryWordBits) | words[2];
      out.first = in.group == 0;
      out.last = in.line_end;
    }
  }

  // Two columns of the group that leaves: the first two as it is read, the other two in the next step.
  MomentsOut leave(bool drain, const Sums& old, Pixels weights) {
#pragma HLS inline
    if (drain) {
      held_weights_ = weights;
      for (int lane = 0; lane < kLanes; ++lane) {
#pragma HLS unroll
        held_.m0[lane] = 0;
        held_.a[lane] = 0;
        held_.n[lane] = 0;
        if (rows_ != 1) {
          held_.m0[lane] = old.m0[lane];
          held_.a[lane] = old.a[lane];
          held_.n[lane] = old.n[lane];
        }
      }
    }
    MomentsOut out;
    out.valid = drain || last_row_.odd();
    Uint<spec::kGreyWordBits> words[2];
    for (int i = 0; i < 2; ++i) {
#pragma HLS unroll
      Sum0 before = held_.m0[i];
      Sum1 a = held_.a[i];
      Row n = held_.n[i];
      Pixel weight = lane_of(held_weights_, i);
      if (last_row_.odd()) {
        before = held_.m0[i + 2];
        a = held_.a[i + 2];
        n = held_.n[i + 2];
        weight = lane_of(held_weights_, i + 2);
      }
      const Sum0 m0 = next_m0(before, weight);
      words[i] = grey_word(m0, finished_m1(rows_, m0, before, a), next_n(n, weight));
    }
    out.low = words[0];
    out.high = words[1];
    out.first = drain && last_row_.group() == 0;
    out.last = last_row_.odd_is_last();
    return out;
  }

  Memory<Sums, kGroups> sums_;
  Recent<Sums, Group> recent_;
  // Grey modes: the last row, and the part of it that still has to leave
  Memory<Pixels, kGroups> line_;
  Recent<Pixels, Group> recent_line_;
  LastRow last_row_;
  Row rows_ = 0;
  Sums held_;
  Pixels held_weights_ = 0;
};

using ColumnMomentsKernel = MomentsKernel<ColumnMoments>;

}  // namespace hls
}  // namespace selfproj

// The kernel for a tool: free-running, one clock for each call. It is outside all namespaces, which some tools require
// of a top function. See column_moments.cpp.
void column_moments_top(selfproj::hls::Stream<selfproj::hls::AxisBeat<32>>& video, selfproj::hls::Columns columns,
                        selfproj::hls::Row rows, selfproj::hls::ModeBits mode, selfproj::hls::Pixel threshold,
                        selfproj::hls::Row first_row, selfproj::hls::Row last_row,
                        selfproj::hls::Stream<selfproj::hls::AxisBeat<128>>& payload);

// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
// NOLINTEND(performance-unnecessary-value-param,modernize-use-equals-default)

#endif  // SELFPROJ_HLS_COLUMN_MOMENTS_H
