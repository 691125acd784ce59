#include "hls/column_moments.h"

using namespace selfproj::hls;

void column_moments_top(Stream<AxisBeat<32>>& video, Columns columns, Row rows, ModeBits mode, Pixel threshold,
                        Row first_row, Row last_row, Stream<AxisBeat<128>>& payload) {
// Free-running like a camera: no start, no done, a call in every clock.
#pragma HLS interface ap_ctrl_none port = return
#pragma HLS interface axis port = video
#pragma HLS interface axis port = payload
// The settings are wires from the board's registers, which are read at a frame's start.
#pragma HLS interface ap_none port = columns
#pragma HLS interface ap_none port = rows
#pragma HLS interface ap_none port = mode
#pragma HLS interface ap_none port = threshold
#pragma HLS interface ap_none port = first_row
#pragma HLS interface ap_none port = last_row
// Four pixels a clock. Flushed, so that what has come leaves even if nothing follows.
#pragma HLS pipeline II = 1 style = flp
  static ColumnMomentsKernel kernel;
  MomentsSetup setup;
  setup.columns = columns;
  setup.rows = rows;
  setup.mode = mode;
  setup.threshold = threshold;
  setup.first_row = first_row;
  setup.last_row = last_row;
  kernel.step(video, setup, payload);
}
