#include "hls/column_runs.h"

using namespace selfproj::hls;

void column_runs_top(Stream<AxisBeat<32>>& video, Columns columns, Row rows, ModeBits mode, Pixel threshold,
                     Uint<1> strongest, Uint<2> gap, Row first_row, Row last_row, Stream<AxisBeat<128>>& payload) {
// As column_moments_top().
#pragma HLS interface ap_ctrl_none port = return
#pragma HLS interface axis port = video
#pragma HLS interface axis port = payload
#pragma HLS interface ap_none port = columns
#pragma HLS interface ap_none port = rows
#pragma HLS interface ap_none port = mode
#pragma HLS interface ap_none port = threshold
#pragma HLS interface ap_none port = strongest
#pragma HLS interface ap_none port = gap
#pragma HLS interface ap_none port = first_row
#pragma HLS interface ap_none port = last_row
#pragma HLS pipeline II = 1 style = flp
  static ColumnRunsKernel kernel;
  MomentsSetup setup;
  setup.columns = columns;
  setup.rows = rows;
  setup.mode = mode;
  setup.threshold = threshold;
  setup.strongest = strongest != 0;
  setup.gap = gap;
  setup.first_row = first_row;
  setup.last_row = last_row;
  kernel.step(video, setup, payload);
}
