#include "hls/gray_decoder.h"

using namespace selfproj::hls;

void gray_decoder_top(Stream<AxisBeat<32>>& video, Uint<13> columns, Uint<12> rows, PlaneCount bits,
                      GrayPixel threshold, Uint<1> median, PatternIndex pattern, Stream<AxisBeat<64>>& codes) {
// Free-running like a camera: no start, no done, a call in every clock.
#pragma HLS interface ap_ctrl_none port = return
#pragma HLS interface axis port = video
#pragma HLS interface axis port = codes
// The settings are wires from the board's registers, and the pattern index is one from its trigger. They are read at a
// frame's start.
#pragma HLS interface ap_none port = columns
#pragma HLS interface ap_none port = rows
#pragma HLS interface ap_none port = bits
#pragma HLS interface ap_none port = threshold
#pragma HLS interface ap_none port = median
#pragma HLS interface ap_none port = pattern
// Four pixels a clock. Flushed, so that what has come leaves even if nothing follows.
#pragma HLS pipeline II = 1 style = flp
  static GrayDecoderKernel<kTopColumns, kTopRows> kernel;
  GraySetup setup;
  setup.columns = columns;
  setup.rows = rows;
  setup.bits = bits;
  setup.threshold = threshold;
  setup.median = median != 0;
  kernel.step(video, setup, pattern, codes);
}
