// When the camera's lines and frames are on the wire, in pixel clocks.
#ifndef SELFPROJ_SIM_PLATFORM_CAMERA_TIMING_H
#define SELFPROJ_SIM_PLATFORM_CAMERA_TIMING_H

#include <cstdint>

namespace selfproj {

// The pixel clock of rig A's camera, in which time stamps count: four pixels a clock, 15,120 clocks a frame at 10,000
// fps.
inline constexpr double kPixelClockHz = 151.2e6;
inline constexpr std::uint64_t kPixelClockPs = 6614;  // its period, to the picosecond

// A frame begins every `frame_clocks`; its lines begin every `line_clocks`, the first with the frame, and carry one
// beat a clock from their beginning on. What is left of a line and, after the last line, of the frame, is blank.
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

// The timing at a frame rate: floor(pixel clock / rate) clocks a frame (15,120 at 10,000 fps), lines spread evenly over
// the frame. Where that is too short for the beats and the smallest blanking (`blank` clocks a line), the frames
// follow as fast as that allows. Rows and columns as the board takes them; rate > 0.
CameraTiming camera_timing(int rows, int columns, double frame_rate_hz, std::uint64_t blank = 4);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_PLATFORM_CAMERA_TIMING_H
