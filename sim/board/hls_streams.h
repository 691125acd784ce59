// Inputs and outputs of the HLS kernels as images and bytes.
#ifndef SELFPROJ_SIM_BOARD_HLS_STREAMS_H
#define SELFPROJ_SIM_BOARD_HLS_STREAMS_H

#include <cstdint>
#include <vector>

#include "hls/types.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::sim {

// A whole frame as beats of video; columns must be a multiple of 4.
inline void push_frame(const model::ImageView& image, hls::Stream<hls::AxisBeat<32>>& video) {
  for (int row = 0; row < image.rows; ++row) {
    const std::uint8_t* line = image.pixels + row * image.stride;
    for (int column = 0; column < image.columns; column += spec::kPixelsPerBeat) {
      std::uint32_t pixels = 0;
      for (int i = spec::kPixelsPerBeat - 1; i >= 0; --i) {
        pixels = pixels << 8U | line[column + i];
      }
      video.write(hls::axis_beat<32>(pixels, row == 0 && column == 0, column + spec::kPixelsPerBeat == image.columns));
    }
  }
}

// The 16 bytes of a beat of payload.
inline void append_beat(const hls::AxisBeat<128>& beat, std::vector<std::uint8_t>& bytes) {
  hls::AxisData<128> data = beat.data;
  for (int i = 0; i < spec::kPacketBeatBytes; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(data.to_uint() & 0xFFU));
    data = data >> 8;
  }
}

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_HLS_STREAMS_H
