// Column moments of a stream of frames, 4 pixels a step, as model/column_moments.h specifies them, for HLS tools.
//
// Three layers:
//   moments_arithmetic.h  operations on one pixel, one sum, one word; the SystemC shell uses them, too
//   ColumnMoments         one step: a beat of 4 pixels in, at most 16 bytes of payload out; keeps the sums
//   ColumnMomentsKernel   one step of the streams: AXI4-Stream video in, payload out; column_moments_top() is one of
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

#include "hls/moments_arithmetic.h"
#include "hls/recent.h"
#include "hls/types.h"
#include "model/spec/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
//   equals-default: the constructor holds pragmas
//   reserved-identifier, identifier-naming: for variables that clang itself makes to copy arrays of structs
// NOLINTBEGIN(performance-unnecessary-value-param,modernize-use-equals-default)
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
namespace selfproj {
namespace hls {

// A beat and its place, or none.
struct MomentsIn {
  bool valid = false;
  Pixels pixels = 0;
  Group group = 0;
  Row row = 0;
  bool first_row = false;
  bool last_row = false;
  bool line_end = false;  // the row's last group
  ModeBits mode = 0;
  Pixel threshold = 0;
  bool broken = false;  // the frame breaks: after this beat, if there is one, no more will come
};

// 16 bytes of payload: four columns in mode binary, two in the grey modes, lowest first. Or nothing.
struct MomentsOut {
  bool valid = false;
  Uint<64> low = 0;
  Uint<64> high = 0;
  bool first = false;  // of the frame
  bool last = false;   // of the frame
};

// Takes rows and columns up to the maxima of the specification.
//
// In mode binary, payload leaves with the step that brings its pixels. In the grey modes group g leaves at the earliest
// with the steps g + 1 and g + 2 after its pixels, two steps for each group. While draining(), only a first row that is
// not the last may come, and while leaving(), no last row of mode binary. ColumnMomentsKernel ensures this. Between
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
  bool draining() const { return ended_; }
  // Payload of such a frame leaves with the next step, whatever comes.
  bool leaving() const { return odd_; }
  // The last row of a frame comes or leaves.
  bool busy() const { return active_ || odd_; }

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
    const bool drain = waiting_ != 0 && !odd_;  // a group that an earlier step pushed

    // One read: of the group that is added up, or of the one that leaves. A first row needs none.
    Group address = in.group;
    if (drain) {
      address = drain_group_;
    }
    const Sums stored = sums_[static_cast<int>(address)];
    const Sums old = recent_.read(address, stored);

    const Pixels stored_weights = line_[static_cast<int>(drain_group_)];
    MomentsOut out = leave(drain, old, recent_line_.read(drain_group_, stored_weights));
    if (add) {
      add_up(in, old, grey, out);
    }
    if (push) {
      const Pixels weights = weights_of(in);
      line_[static_cast<int>(in.group)] = weights;
      recent_line_.write(in.group, weights);
      rows_ = in.row;
    }
    control(push, push && in.line_end, in.broken, drain);
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

  static Pixels weights_of(const MomentsIn& in) {
#pragma HLS inline
    Pixels weights = 0;
    for (int lane = kLanes - 1; lane >= 0; --lane) {
#pragma HLS unroll
      weights = (weights << spec::kPixelBits) | weight_of(lane_of(in.pixels, lane), in.threshold, in.mode);
    }
    return weights;
  }

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
    out.valid = drain || odd_;
    Uint<spec::kGreyWordBits> words[2];
    for (int i = 0; i < 2; ++i) {
#pragma HLS unroll
      Sum0 before = held_.m0[i];
      Sum1 a = held_.a[i];
      Row n = held_.n[i];
      Pixel weight = lane_of(held_weights_, i);
      if (odd_) {
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
    out.first = drain && drain_group_ == 0;
    out.last = odd_ && odd_last_;
    return out;
  }

  // Keeps track of what waits in the line buffer.
  void control(bool push, bool push_end, bool broken, bool drain) {
#pragma HLS inline
    Uint<kWaitingBits> waiting = waiting_;
    if (push && !drain) {
      waiting = waiting + 1;
    } else if (!push && drain) {
      waiting = waiting - 1;
    }
    const bool cut = broken_ || (broken && (push || (active_ && !ended_)));  // but not for a frame that came later
    const bool ended = ended_ || push_end || cut;
    const bool last = ended && waiting == 0;  // nothing is left in the line buffer
    odd_ = drain;
    odd_last_ = last && !cut;
    broken_ = cut && !last;
    active_ = (active_ || push) && !last;
    ended_ = ended && !last;
    waiting_ = waiting;
    if (last) {
      drain_group_ = 0;
    } else if (drain) {
      drain_group_ = drain_group_ + 1;
    }
  }

  static constexpr int kWaitingBits = bits_for(kGroups);

  Memory<Sums, kGroups> sums_;
  Recent<Sums, Group> recent_;
  // Grey modes: the last row, and the part of it that still has to leave
  Memory<Pixels, kGroups> line_;
  Recent<Pixels, Group> recent_line_;
  Uint<kWaitingBits> waiting_ = 0;  // groups in the line buffer
  Group drain_group_ = 0;           // next group to drain
  bool active_ = false;             // a last row comes or leaves
  bool ended_ = false;              // no more of it will come
  bool broken_ = false;             // it ended because its frame broke
  bool odd_ = false;                // the other two columns of the group read in the last step leave now
  bool odd_last_ = false;           // these are the frame's last
  Row rows_ = 0;
  Sums held_;
  Pixels held_weights_ = 0;
};

// --- Streams ---

// The settings, taken over at each frame's start: columns a multiple of 4 from 4, rows from 1.
struct MomentsSetup {
  Columns columns = 0;
  Row rows = 0;
  ModeBits mode = 0;
  Pixel threshold = 0;
};

// Turns video beats (tuser: start of frame, tlast: end of line) into payload (tuser: first beat of a frame, tlast:
// last).
//
// Beats before a start are dropped. A line that ends too early or too late breaks its frame, and a start begins a new
// frame at any time. A frame that breaks in its last row gives the payload of the columns it had, without tlast. One
// that breaks earlier gives nothing.
class ColumnMomentsKernel {
 public:
  // One clock. Returns true while more steps without input would give more output.
  bool step(Stream<AxisBeat<32>>& video, const MomentsSetup& setup, Stream<AxisBeat<128>>& payload) {
#pragma HLS inline
    late_memory_step();
    MomentsIn in;
    AxisBeat<32> beat;
    if (holds_) {
      if (!moments_.busy()) {
        holds_ = false;
        place(held_, held_setup_, in);
      }
    } else if (may_read(setup) && video.read_nb(beat)) {
      if (beat.user != 0 && open_ && moments_.busy()) {  // after a frame that broke, the next one waits until it is out
        in.broken = true;
        open_ = false;
        holds_ = true;
        held_ = beat;
        held_setup_ = setup;
      } else {
        place(beat, setup, in);
      }
    }
    const MomentsOut out = moments_.step(in);
    if (out.valid) {
      AxisData<128> data(out.high);
      data = data << 64;
      data = data | AxisData<128>(out.low);
      payload.write(axis_beat<128>(data, out.first, out.last));
    }
    return moments_.busy() || holds_;
  }

 private:
  // A row waits only if both it and a drain need a read, and a last row if it has no room in the line buffer or at the
  // exit. This happens only after a change of size or mode, or with frames of one row.
  bool may_read(const MomentsSetup& setup) const {
#pragma HLS inline
    const bool at_start = !open_ || (row_ == 1 && group_ == 0);
    const bool first_row = at_start || row_ == 1;
    Row rows = rows_;
    ModeBits mode = mode_;
    if (at_start) {
      rows = setup.rows;
      mode = setup.mode;
    }
    const bool last_row = at_start ? rows == 1 : row_ == rows;
    const bool exit_taken = moments_.leaving() && last_row && mode == spec::kModeBinary;
    return (!moments_.draining() || (first_row && !last_row)) && !exit_taken;
  }

  void place(const AxisBeat<32>& beat, const MomentsSetup& setup, MomentsIn& in) {
#pragma HLS inline
    const bool start = beat.user != 0;
    const bool line_end = beat.last != 0;
    if (start) {
      open_ = true;
      row_ = 1;
      group_ = 0;
      rows_ = setup.rows;
      mode_ = setup.mode;
      threshold_ = setup.threshold;
      last_group_ = (setup.columns >> 2) - 1;
    }
    if (open_) {
      in.valid = true;
      in.pixels = beat.data.to_uint();
      in.group = group_;
      in.row = row_;
      in.first_row = row_ == 1;
      in.last_row = row_ == rows_;
      in.line_end = group_ == last_group_;
      in.mode = mode_;
      in.threshold = threshold_;
      if (line_end != in.line_end) {
        in.line_end = false;
        in.broken = true;
        open_ = false;
      } else if (line_end) {
        open_ = !in.last_row;
        row_ = row_ + 1;
        group_ = 0;
      } else {
        group_ = group_ + 1;
      }
    }
  }

  ColumnMoments moments_;
  bool holds_ = false;  // a start is waiting
  AxisBeat<32> held_;
  MomentsSetup held_setup_;
  bool open_ = false;  // a frame is under way
  Row row_ = 1;        // row of the next beat
  Group group_ = 0;
  // Of the current frame
  Row rows_ = 1;
  Group last_group_ = 0;
  ModeBits mode_ = 0;
  Pixel threshold_ = 0;
};

}  // namespace hls
}  // namespace selfproj

// The kernel for a tool: free-running, one clock for each call. It is outside all namespaces, which some tools require
// of a top function. See column_moments.cpp.
void column_moments_top(selfproj::hls::Stream<selfproj::hls::AxisBeat<32>>& video, selfproj::hls::Columns columns,
                        selfproj::hls::Row rows, selfproj::hls::ModeBits mode, selfproj::hls::Pixel threshold,
                        selfproj::hls::Stream<selfproj::hls::AxisBeat<128>>& payload);

// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
// NOLINTEND(performance-unnecessary-value-param,modernize-use-equals-default)

#endif  // SELFPROJ_HLS_COLUMN_MOMENTS_H
