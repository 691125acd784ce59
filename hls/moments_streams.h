// What goes into and comes out of a step of the column moments, and the kernel around it with the streams of a tool:
// for the plain moments (column_moments.h) and the strongest runs (column_runs.h).
#ifndef SELFPROJ_HLS_MOMENTS_STREAMS_H
#define SELFPROJ_HLS_MOMENTS_STREAMS_H

#include "hls/moments_arithmetic.h"
#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
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
  bool strongest = false;  // select: strongest, not all
  Uint<2> gap = 0;         // dark rows that a run may have inside
  bool broken = false;     // the frame breaks: after this beat, if there is one, no more will come
};

// 16 bytes of payload: four columns in mode binary, two in the grey modes, lowest first. Or nothing.
struct MomentsOut {
  bool valid = false;
  Uint<64> low = 0;
  Uint<64> high = 0;
  bool first = false;  // of the frame
  bool last = false;   // of the frame
};

// --- Streams ---

// The settings, taken over at each frame's start: columns a multiple of 4 from 4, rows from 1.
struct MomentsSetup {
  Columns columns = 0;
  Row rows = 0;
  ModeBits mode = 0;
  Pixel threshold = 0;
  bool strongest = false;  // ColumnRuns only, and the gap
  Uint<2> gap = 0;
  Row first_row = 0;  // rows that count; 0: no limit
  Row last_row = 0;
};

// Turns video beats (tuser: start of frame, tlast: end of line) into payload (tuser: first beat of a frame, tlast:
// last).
//
// Beats before a start are dropped. A line that ends too early or too late breaks its frame, and a start begins a new
// frame at any time. A frame that breaks in its last row gives the payload of the columns it had, without tlast. One
// that breaks earlier gives nothing.
template <typename Core>
class MomentsKernel {
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
    return (!moments_.draining() || (first_row && !last_row)) && !moments_.exit_taken(last_row, mode);
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
      strongest_ = setup.strongest;
      gap_ = setup.gap;
      first_row_ = setup.first_row;
      last_row_ = setup.last_row;
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
      if (row_ < first_row_ || (row_ > last_row_ && last_row_ != 0)) {
        in.threshold = (1 << spec::kPixelBits) - 1;  // no pixel is lit in a row that does not count
      }
      in.strongest = strongest_;
      in.gap = gap_;
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

  Core moments_;
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
  bool strongest_ = false;
  Uint<2> gap_ = 0;
  Row first_row_ = 0;
  Row last_row_ = 0;
};

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_MOMENTS_STREAMS_H
