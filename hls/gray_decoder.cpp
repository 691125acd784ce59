#include "hls/gray_decoder.h"

using namespace selfproj::hls;

void gray_decoder_top(Stream<AxisBeat<32>>& video, Uint<13> columns, Uint<12> rows, PlaneCount bits,
                      GrayPixel threshold, Uint<1> median, PatternIndex pattern, Stream<AxisBeat<64>>& codes) {
// The circuit runs freely, like a camera. It has no start and no done signal. Each clock is one call of this function.
#pragma HLS interface ap_ctrl_none port = return
#pragma HLS interface axis port = video
#pragma HLS interface axis port = codes
// The settings come by wires from the board's registers, and the pattern index from its trigger. The circuit reads them
// at the start of a frame.
#pragma HLS interface ap_none port = columns
#pragma HLS interface ap_none port = rows
#pragma HLS interface ap_none port = bits
#pragma HLS interface ap_none port = threshold
#pragma HLS interface ap_none port = median
#pragma HLS interface ap_none port = pattern
// The circuit takes four pixels in each clock. The pipeline is of the kind that flushes, so that codes leave it even if
// no more pixels come.
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
