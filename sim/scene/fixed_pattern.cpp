#include "sim/scene/fixed_pattern.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/scene/noise.h"

namespace selfproj {

FixedPatternMap::FixedPatternMap(const FixedPattern& pattern, double electrons_per_grey, std::size_t pixels,
                                 std::uint64_t seed)
    : gains_(pixels), offsets_(pixels) {
  constexpr std::uint64_t kStream = 0x46504e;  // apart from those of frames
  NormalNoise noise(seed, kStream);
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto [gain, offset] = noise.two();
    gains_[i] = 1 + static_cast<float>(pattern.prnu) * gain;
    offsets_[i] = static_cast<float>(pattern.dsnu_electrons / electrons_per_grey) * offset;
  }
}

void FixedPatternMap::add_gains(double dark, std::span<float> pixels) const {
  const auto zero = static_cast<float>(dark);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = zero + gains_[i] * (pixels[i] - zero);
  }
}

void FixedPatternMap::add_offsets(std::span<float> pixels) const {
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] += offsets_[i];
  }
}

}  // namespace selfproj
