#include "sim/scene/lens_kernel.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace selfproj {

int lens_margin(double blur) { return blur > 0 ? static_cast<int>(std::ceil(4 * blur)) : 0; }

std::vector<float> lens_kernel(double blur) {
  const int margin = lens_margin(blur);
  const auto below = [&](double d) {  // share of the Gaussian below d
    return blur > 0 ? 0.5 * std::erfc(-d / (blur * std::numbers::sqrt2)) : static_cast<double>(d > 0);
  };
  std::vector<double> weights;
  double sum = 0;
  for (int k = 0; k < (2 * margin + 1) * kSubPixels; ++k) {
    const double d = (k + 0.5) / kSubPixels - margin - 0.5;  // from the pixel's centre
    weights.push_back(below(d + 0.5) - below(d - 0.5));
    sum += weights.back();
  }
  std::vector<float> kernel(weights.size());
  std::transform(weights.begin(), weights.end(), kernel.begin(),
                 [sum](double weight) { return static_cast<float>(weight / sum); });
  return kernel;
}

}  // namespace selfproj
