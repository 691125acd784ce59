#include "sim/platform/camera_timing.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::sim {

CameraTiming camera_timing(int rows, int columns, double frame_rate_hz, double pixel_clock_hz, std::uint64_t blank) {
  if (rows < 1 || rows > spec::kMaxRows || columns < spec::kPixelsPerBeat || columns > spec::kMaxColumns ||
      columns % spec::kPixelsPerBeat != 0) {
    throw std::invalid_argument("camera_timing: the board takes no images of this size");
  }
  if (!(frame_rate_hz > 0 && frame_rate_hz <= pixel_clock_hz)) {
    throw std::invalid_argument("camera_timing: impossible frame rate");
  }
  CameraTiming timing{.columns = columns, .rows = rows};
  const auto lines = static_cast<std::uint64_t>(rows);
  const std::uint64_t shortest_line = timing.beats_a_line() + blank;
  timing.frame_clocks = std::max(static_cast<std::uint64_t>(pixel_clock_hz / frame_rate_hz), lines * shortest_line);
  timing.line_clocks = timing.frame_clocks / lines;
  return timing;
}

}  // namespace selfproj::sim
