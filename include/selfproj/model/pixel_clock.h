// The pixel clock of a board, in which its time stamps count.
#ifndef SELFPROJ_MODEL_PIXEL_CLOCK_H
#define SELFPROJ_MODEL_PIXEL_CLOCK_H

#include <cstdint>

namespace selfproj::model {

// The pixel clock of a board about which nothing else is known: that of rig A's camera, with four pixels a clock and
// 15,120 clocks a frame at 10,000 frames a second. Neither the registers nor the packets contain it. A rig may
// (board.pixel_clock_hz), and the programs have an option for it.
inline constexpr double kDefaultPixelClockHz = 151.2e6;

// The range of pixel clocks, in Hz.
inline constexpr double kMinPixelClockHz = 1e3;
inline constexpr double kMaxPixelClockHz = 1e10;

// The seconds that this many clocks take, for example a difference of time stamps.
constexpr double seconds_of_clocks(std::uint64_t clocks, double pixel_clock_hz) {
  return static_cast<double>(clocks) / pixel_clock_hz;
}

// The period, rounded to a picosecond: 6614 for the default.
constexpr std::uint64_t pixel_clock_period_ps(double pixel_clock_hz) {
  const double period = 1e12 / pixel_clock_hz;
  const auto whole = static_cast<std::uint64_t>(period);
  return whole + (period - static_cast<double>(whole) >= 0.5 ? 1 : 0);
}

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_PIXEL_CLOCK_H
