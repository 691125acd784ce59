#include "sim/scene/texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "sim/scene/even_numbers.h"

namespace selfproj {

TextureField::TextureField(const Texture& texture, std::uint64_t seed)
    : amplitude_(texture.contrast * std::sqrt(2.0 / kWaves)) {
  EvenNumbers random(seed);
  const double k = 2 * std::numbers::pi / texture.scale_mm;
  const double first = random.next();
  for (std::size_t i = 0; i < waves_.size(); ++i) {
    const double direction = std::numbers::pi * (static_cast<double>(i) + first) / kWaves;
    waves_.at(i) = {k * std::cos(direction), k * std::sin(direction), 2 * std::numbers::pi * random.next()};
  }
}

double TextureField::at(double x, double y) const {
  constexpr double kLeast = 0.05;
  double sum = 0;
  for (const Wave& wave : waves_) {
    sum += std::cos(wave.along_x * x + wave.along_y * y + wave.phase);
  }
  return std::max(kLeast, 1 + amplitude_ * sum);
}

}  // namespace selfproj
