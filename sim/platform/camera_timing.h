// When the camera's lines and frames are on the wire, in pixel clocks; and what the encoder's pins show.
#ifndef SELFPROJ_SIM_PLATFORM_CAMERA_TIMING_H
#define SELFPROJ_SIM_PLATFORM_CAMERA_TIMING_H

#include <cstdint>

#include "selfproj/model/pixel_clock.h"

namespace selfproj::sim {

// A frame begins every `frame_clocks`. Its lines begin every `line_clocks`, the first with the frame, and carry one
// beat a clock from their beginning. The rest of a line and, after the last line, of the frame is blank.
//
//     frame   |<------------------------ frame_clocks ------------------------>|
//     line 1  |beats|blank|
//     line 2              |beats|blank|
//     ...                                        line R  |beats|blank|  blank  |
struct CameraTiming {
  std::uint64_t frame_clocks = 0;
  std::uint64_t line_clocks = 0;
  int columns = 0;
  int rows = 0;

  [[nodiscard]] std::uint64_t beats_a_line() const { return static_cast<std::uint64_t>(columns) / 4; }
  [[nodiscard]] std::uint64_t beats() const { return beats_a_line() * static_cast<std::uint64_t>(rows); }
};

// The timing for a frame rate and a pixel clock: floor(clock / rate) clocks a frame (15,120 at 10,000 fps and 151.2
// MHz), with lines spread evenly over the frame. If that is too short for the beats and the smallest blanking (`blank`
// clocks a line), frames follow as fast as these allow. Rows and columns must suit the board; rate > 0.
CameraTiming camera_timing(int rows, int columns, double frame_rate_hz,
                           double pixel_clock_hz = model::kDefaultPixelClockHz, std::uint64_t blank = 4);

// The levels of an encoder's pins after so many steps forward, in which A leads B.
struct EncoderLevels {
  bool a = false;
  bool b = false;
};
constexpr EncoderLevels levels_of_step(std::uint64_t step) {
  const std::uint64_t phase = step & 3U;
  return {.a = phase == 1 || phase == 2, .b = phase == 2 || phase == 3};
}

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_PLATFORM_CAMERA_TIMING_H
