#include "sim/scene/pattern_set.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/images/float_image.h"

namespace selfproj {

ProjectedLight project_image(const Rig& rig, const Image& image, const RenderOptions& options,
                             const std::string& source) {
  constexpr float kFull = 255;
  FloatImage light(image.rows, image.columns);
  std::transform(image.pixels.begin(), image.pixels.end(), light.values.begin(),
                 [](std::uint8_t value) { return static_cast<float>(value) / kFull; });
  check_pattern(light, rig.projector, source);
  return throw_light(rig, light, options);
}

PatternSet::PatternSet(const Rig& rig, std::span<const Image> images, const RenderOptions& options) {
  if (images.empty()) {
    throw std::invalid_argument("a set of no patterns");
  }
  light_.reserve(images.size());
  for (const Image& image : images) {
    light_.push_back(project_image(rig, image, options));
  }
}

// g_2i = floor(2^i Y/H + 1/2) mod 2, in integers.
std::vector<Image> gray_patterns(const RigProjector& projector, int bits) {
  constexpr int kMostBits = 12;
  if (bits < 1 || bits > kMostBits) {
    throw std::invalid_argument("Gray patterns of other than 1..12 bits");
  }
  constexpr std::uint8_t kFull = 255;
  const std::int64_t lines = projector.lines;
  std::vector<Image> patterns;
  for (int i = 0; i < bits; ++i) {
    for (const bool positive : {true, false}) {
      Image image{projector.lines, projector.columns, {}};
      image.pixels.reserve(static_cast<std::size_t>(lines) * static_cast<std::size_t>(projector.columns));
      for (std::int64_t line = 0; line < lines; ++line) {
        const bool lit = ((2 * (line << i) + lines) / (2 * lines)) % 2 == 1;
        image.pixels.insert(image.pixels.end(), static_cast<std::size_t>(projector.columns),
                            lit == positive ? kFull : std::uint8_t{0});
      }
      patterns.push_back(std::move(image));
    }
  }
  return patterns;
}

}  // namespace selfproj
