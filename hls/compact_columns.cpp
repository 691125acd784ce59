#include "hls/compact_columns.h"

using namespace selfproj::hls;

void compact_columns_top(Stream<AxisBeat<128>>& payload, Uint<1> strongest, Stream<AxisBeat<128>>& compact) {
// As column_moments_top().
#pragma HLS interface ap_ctrl_none port = return
#pragma HLS interface axis port = payload
#pragma HLS interface axis port = compact
#pragma HLS interface ap_none port = strongest
#pragma HLS pipeline II = 1 style = flp
  static CompactColumnsKernel kernel;
  kernel.step(payload, strongest != 0, compact);
}
