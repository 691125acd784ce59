#include "sim/scene/gaussian_kernel.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace selfproj {

std::vector<double> gaussian_kernel(double sigma) {
  const int reach = static_cast<int>(std::ceil(kKernelReach * sigma));
  std::vector<double> kernel(static_cast<std::size_t>(2 * reach + 1));
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double weight = sigma > 0 ? std::exp(-0.5 * k * k / (sigma * sigma)) : 1;
    kernel[static_cast<std::size_t>(k + reach)] = weight;
    sum += weight;
  }
  for (double& weight : kernel) {
    weight /= sum;
  }
  return kernel;
}

}  // namespace selfproj
