#include "host/report/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace selfproj {
namespace {

using Stop = std::array<double, 3>;

// ColorBrewer's RdBu, from blue to red (Brewer and others 2003, Apache 2.0): eleven colours in even steps, safe for
// those who cannot tell red from green.
constexpr std::array<Stop, 11> kDiverging = {{{0x05, 0x30, 0x61},
                                              {0x21, 0x66, 0xAC},
                                              {0x43, 0x93, 0xC3},
                                              {0x92, 0xC5, 0xDE},
                                              {0xD1, 0xE5, 0xF0},
                                              {0xF7, 0xF7, 0xF7},
                                              {0xFD, 0xDB, 0xC7},
                                              {0xF4, 0xA5, 0x82},
                                              {0xD6, 0x60, 0x4D},
                                              {0xB2, 0x18, 0x2B},
                                              {0x67, 0x00, 0x1F}}};

// Every eighth of viridis (van der Walt and Smith 2015, CC0).
constexpr std::array<Stop, 9> kSequential = {{{0x44, 0x01, 0x54},
                                              {0x47, 0x2D, 0x7B},
                                              {0x3B, 0x52, 0x8B},
                                              {0x2C, 0x72, 0x8E},
                                              {0x21, 0x91, 0x8C},
                                              {0x28, 0xAE, 0x80},
                                              {0x5E, 0xC9, 0x62},
                                              {0xAD, 0xDC, 0x30},
                                              {0xFD, 0xE7, 0x25}}};

template <std::size_t Count>
Colour between(const std::array<Stop, Count>& stops, double t) {
  const double place = std::clamp(t, 0.0, 1.0) * static_cast<double>(Count - 1);
  const auto low = std::min(static_cast<std::size_t>(place), Count - 2);
  const double share = place - static_cast<double>(low);
  const auto mix = [&](std::size_t i) {
    return static_cast<std::uint8_t>(std::lround(stops[low][i] + share * (stops[low + 1][i] - stops[low][i])));
  };
  return {mix(0), mix(1), mix(2)};
}

}  // namespace

Colour colour_at(ColourMap map, double t) {
  return map == ColourMap::diverging ? between(kDiverging, t) : between(kSequential, t);
}

}  // namespace selfproj
