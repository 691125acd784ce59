#include "sim/scene/defect_pixels.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "sim/scene/even_numbers.h"

namespace selfproj {

DefectMap::DefectMap(const DefectPixels& defects, std::size_t pixels, std::uint64_t seed) {
  constexpr double kWhite = 255;
  EvenNumbers random(seed);
  for (std::size_t i = 0; i < pixels; ++i) {
    const double drawn = random.next();
    if (drawn < defects.hot) {
      const double level = defects.least_hot_grey + (kWhite - defects.least_hot_grey) * random.next();
      hot_.push_back({i, static_cast<float>(level)});
    } else if (drawn < defects.hot + defects.dead) {
      dead_.push_back(i);
    }
  }
}

void DefectMap::apply(double dark, std::span<float> pixels) const {
  for (const Hot& hot : hot_) {
    pixels[hot.pixel] += hot.offset;
  }
  for (const std::size_t i : dead_) {
    pixels[i] = static_cast<float>(dark);
  }
}

}  // namespace selfproj
