#include "sim/scene/row_noise.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "sim/scene/noise.h"

namespace selfproj {

void add_row_noise(const RowNoise& noise, std::uint64_t seed, int frame, int columns, std::span<float> pixels) {
  constexpr std::uint64_t kApart = 0x726f7773;  // from the noise of pixels
  NormalNoise random(seed + kApart, static_cast<std::uint64_t>(frame));
  const auto width = static_cast<std::size_t>(columns);
  for (std::size_t first = 0; first < pixels.size(); first += width) {
    const float offset = static_cast<float>(noise.grey) * random.two().first;
    for (float& value : pixels.subspan(first, width)) {
      value += offset;
    }
  }
}

}  // namespace selfproj
