// Colours for numbers.
#ifndef SELFPROJ_HOST_REPORT_COLOUR_MAP_H
#define SELFPROJ_HOST_REPORT_COLOUR_MAP_H

#include <cstdint>

namespace selfproj {

struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
};

enum class ColourMap : std::uint8_t {
  diverging,   // blue - white - red, perceptually symmetric about white: for signed values around 0
  sequential,  // viridis, dark to light in perceptually even steps: for heights
};

// The colour at t, which is clamped to 0..1 and must not be NaN.
Colour colour_at(ColourMap map, double t);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_COLOUR_MAP_H
