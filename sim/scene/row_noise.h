// Row noise: every row of a frame gets an offset of its own, because its pixels are read together.
#ifndef SELFPROJ_SIM_SCENE_ROW_NOISE_H
#define SELFPROJ_SIM_SCENE_ROW_NOISE_H

#include <cstdint>
#include <span>

namespace selfproj {

struct RowNoise {
  double grey = 0;  // standard deviation
};

// Adds the offsets of a frame, normal and new in every frame, to an image of this many columns.
void add_row_noise(const RowNoise& noise, std::uint64_t seed, int frame, int columns, std::span<float> pixels);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_ROW_NOISE_H
