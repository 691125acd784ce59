#include "lab/structured_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace selfproj {

std::string figure_text(double value, int digits) {
  return std::isnan(value) ? "–" : fmt::format("{:.{}f}", value, digits);
}

FloatImage minus(const FloatImage& a, const FloatImage& b) {
  FloatImage result = a;
  std::transform(a.values.begin(), a.values.end(), b.values.begin(), result.values.begin(), std::minus<>());
  return result;
}

}  // namespace selfproj
