// Fixed-pattern noise of a sensor as EMVA 1288 states it: offsets in the dark (DSNU) and gains (PRNU) of its pixels.
#ifndef SELFPROJ_SIM_SCENE_FIXED_PATTERN_H
#define SELFPROJ_SIM_SCENE_FIXED_PATTERN_H

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace selfproj {

struct FixedPattern {
  double dsnu_electrons = 0;  // standard deviation of the offsets
  double prnu = 0;            // standard deviation of the gains
};

// The same offsets and gains in every frame of a camera.
class FixedPatternMap {
 public:
  FixedPatternMap(const FixedPattern& pattern, double electrons_per_grey, std::size_t pixels, std::uint64_t seed);

  // dark + gain (value - dark); before the noise, because electrons are counted after it.
  void add_gains(double dark, std::span<float> pixels) const;

  void add_offsets(std::span<float> pixels) const;

 private:
  std::vector<float> gains_;
  std::vector<float> offsets_;  // grey values
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_FIXED_PATTERN_H
