// The strongest run of every column of a stream of frames, 4 pixels a step, as include/selfproj/model/column_runs.h
// specifies it, for HLS tools.
//
// The layers are those of column_moments.h; the pure functions of the runs are in runs_arithmetic.h, the kernel of the
// streams is in moments_streams.h. A step is a clock: the tool pipelines it with an initiation interval of 1.
//
// The last row ends all runs. In every mode it waits in a line buffer, and its columns leave two a step.
#ifndef SELFPROJ_HLS_COLUMN_RUNS_H
#define SELFPROJ_HLS_COLUMN_RUNS_H

#include "hls/last_row.h"
#include "hls/moments_arithmetic.h"
#include "hls/moments_streams.h"
#include "hls/recent.h"
#include "hls/runs_arithmetic.h"
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
// Group g leaves at the earliest with the steps g + 1 and g + 2 after its pixels, in the grey modes two columns with
// each, in mode binary all four with the second. While draining(), only a first row that is not the last may come.
// MomentsKernel ensures this. Between frames of one size it never has to wait.
class ColumnRuns {
 public:
  ColumnRuns() {
// What the four lanes keep is one word of each of two memories: one read and one write a step.
#pragma HLS aggregate variable = open_ compact = bit
#pragma HLS aggregate variable = ended_ compact = bit
#pragma HLS bind_storage variable = open_ type = ram_s2p impl = bram
#pragma HLS bind_storage variable = ended_ type = ram_s2p impl = bram
#pragma HLS bind_storage variable = line_ type = ram_s2p impl = bram
#pragma HLS array_partition variable = held_.lane complete
  }

  // The last row of a frame has ended and is still being read.
  bool draining() const { return last_row_.draining(); }
  // All payload leaves by way of the line buffer.
  static bool exit_taken(bool /*last_row*/, ModeBits /*mode*/) { return false; }
  // The last row of a frame comes or leaves.
  bool busy() const { return last_row_.busy(); }

  MomentsOut step(const MomentsIn& in) {
#pragma HLS inline
// As in ColumnMoments: the memories are read at the earliest kMemoryDistance steps after a write, and the write of a
// first row never comes before the read of a drained group.
#pragma HLS dependence variable = open_ type = inter direction = RAW distance = 4 true
#pragma HLS dependence variable = ended_ type = inter direction = RAW distance = 4 true
#pragma HLS dependence variable = line_ type = inter direction = RAW distance = 4 true
#pragma HLS dependence variable = open_ type = inter direction = WAR false
#pragma HLS dependence variable = ended_ type = inter direction = WAR false
    static_assert(kMemoryDistance == 4, "the distance in the pragma");
    const bool push = in.valid && in.last_row;
    const bool drain = last_row_.drains();
    const Pixels weights = weights_of(in.pixels, in.threshold, in.mode);

    // One read of each: of the group that is added up, or of the one that leaves. A first row needs none.
    Group address = in.group;
    if (drain) {
      address = last_row_.group();
    }
    const OpenRuns stored_open = open_[static_cast<int>(address)];
    const Ended stored_ended = ended_[static_cast<int>(address)];
    const Pixels stored_weights = line_[static_cast<int>(last_row_.group())];
    const OpenRuns open = recent_open_.read(address, stored_open);
    const Ended ended = recent_ended_.read(address, stored_ended);
    MomentsOut out = leave(drain, open, ended, recent_line_.read(last_row_.group(), stored_weights));
    if (in.valid && !push) {
      add_up(in, weights, open, ended);
    }
    if (push) {
      line_[static_cast<int>(in.group)] = weights;
      recent_line_.write(in.group, weights);
      rows_ = in.row;
      grey_ = in.mode != spec::kModeBinary;
      strongest_ = in.strongest;
    }
    last_row_.step(push, push && in.line_end, in.broken, drain);
    return out;
  }

 private:
  static constexpr int kGroups = spec::kMaxColumns / kLanes;

  struct OpenRuns {
    OpenRun lane[kLanes];
  };
  struct Ended {
    EndedRuns lane[kLanes];
  };

  void add_up(const MomentsIn& in, Pixels weights, const OpenRuns& open, const Ended& ended) {
#pragma HLS inline
    OpenRuns next_open;
    Ended next;
    for (int lane = 0; lane < kLanes; ++lane) {
#pragma HLS unroll
      OpenRun run;
      run.clear();
      next.lane[lane].clear();
      if (!in.first_row) {
        run = open.lane[lane];
        next.lane[lane] = ended.lane[lane];
      }
      bool ends = false;
      next_open.lane[lane] = next_run(run, lane_of(weights, lane), in.strongest, in.gap, ends);
      if (ends) {
        next.lane[lane] = next_ended(next.lane[lane], next_open.lane[lane], in.row);
      }
    }
    open_[static_cast<int>(in.group)] = next_open;
    recent_open_.write(in.group, next_open);
    ended_[static_cast<int>(in.group)] = next;
    recent_ended_.write(in.group, next);
  }

  // Two columns of the group that leaves: the first two as it is read, the other two in the next step.
  MomentsOut leave(bool drain, const OpenRuns& open, const Ended& ended, Pixels weights) {
#pragma HLS inline
    const bool odd = last_row_.odd();
    if (drain) {
      for (int lane = 0; lane < kLanes; ++lane) {
#pragma HLS unroll
        OpenRun run;
        EndedRuns all;
        run.clear();
        all.clear();
        if (rows_ != 1) {
          run = open.lane[lane];
          all = ended.lane[lane];
        }
        bool ends = false;
        const OpenRun complete = next_run(run, lane_of(weights, lane), false, 0, ends);
        if (complete.open) {
          all = next_ended(all, complete, rows_);
        }
        held_.lane[lane] = all;
      }
    }
    Uint<spec::kGreyRunWordBits> grey[2];
    Uint<spec::kBinaryRunWordBits> binary[2];
    for (int i = 0; i < 2; ++i) {
#pragma HLS unroll
      EndedRuns run = held_.lane[i];
      if (odd) {
        run = held_.lane[i + 2];
      }
      const Sum1 m1 = finished_m1(run.row, run.m0, 0, run.a);
      Uint<2> runs = 0;
      Uint<5> second = 0;
      if (strongest_) {
        runs = run.runs;
        second = ratio_of(run.second, run.m0);
      }
      grey[i] = grey_run_word(grey_word(run.m0, m1, run.n), runs, second);
      binary[i] = binary_run_word(binary_word(run.m0, m1), runs, second);
    }
    MomentsOut out;
    if (grey_) {
      out.valid = drain || odd;
      out.low = grey[0];
      out.high = grey[1];
      out.first = drain && last_row_.group() == 0;
    } else {
      out.valid = odd;
      out.low = pair_;
      const Uint<64> high = binary[1];
      pair_ = (high << spec::kBinaryRunWordBits) | binary[0];
      out.high = pair_;
      out.first = odd && first_;
    }
    first_ = drain && last_row_.group() == 0;
    out.last = last_row_.odd_is_last();
    return out;
  }

  Memory<OpenRuns, kGroups> open_ = {};
  Memory<Ended, kGroups> ended_ = {};
  Memory<Pixels, kGroups> line_;  // the last row
  Recent<OpenRuns, Group> recent_open_;
  Recent<Ended, Group> recent_ended_;
  Recent<Pixels, Group> recent_line_;
  LastRow last_row_;
  // Of the row that leaves
  Row rows_ = 0;
  bool grey_ = false;
  bool strongest_ = false;
  Ended held_ = {};     // the group that leaves
  Uint<64> pair_ = 0;   // mode binary: its first two columns
  bool first_ = false;  // it is the frame's first
};

using ColumnRunsKernel = MomentsKernel<ColumnRuns>;

}  // namespace hls
}  // namespace selfproj

// The kernel for a tool, as column_moments_top().
void column_runs_top(selfproj::hls::Stream<selfproj::hls::AxisBeat<32>>& video, selfproj::hls::Columns columns,
                     selfproj::hls::Row rows, selfproj::hls::ModeBits mode, selfproj::hls::Pixel threshold,
                     selfproj::hls::Uint<1> strongest, selfproj::hls::Uint<2> gap, selfproj::hls::Row first_row,
                     selfproj::hls::Row last_row, selfproj::hls::Stream<selfproj::hls::AxisBeat<128>>& payload);

// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
// NOLINTEND(performance-unnecessary-value-param,modernize-use-equals-default)

#endif  // SELFPROJ_HLS_COLUMN_RUNS_H
