#include "sim/scene/saturation.h"

#include <algorithm>
#include <span>

namespace selfproj {

void saturate(const Saturation& saturation, double dark, std::span<float> pixels) {
  for (float& value : pixels) {
    value = static_cast<float>(
        std::min(dark + saturation.exposure * (static_cast<double>(value) - dark), saturation.well_grey));
  }
}

}  // namespace selfproj
