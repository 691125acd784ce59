#ifndef SELFPROJ_SIM_SCENE_GAUSSIAN_KERNEL_H
#define SELFPROJ_SIM_SCENE_GAUSSIAN_KERNEL_H

#include <vector>

namespace selfproj {

inline constexpr double kKernelReach = 4;  // of a blur, in standard deviations

// The weights of a Gaussian of standard deviation `sigma` at integers from -4 sigma to 4 sigma, of sum 1.
std::vector<double> gaussian_kernel(double sigma);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_GAUSSIAN_KERNEL_H
