// What the camera's lens and its square pixels make of an image of sub-pixels.
#ifndef SELFPROJ_SIM_SCENE_LENS_KERNEL_H
#define SELFPROJ_SIM_SCENE_LENS_KERNEL_H

#include <vector>

namespace selfproj {

// Sub-pixels along a side of a pixel.
inline constexpr int kSubPixels = 4;

// Pixels around the image that a lens with a Gaussian blur of this standard deviation, in pixels, draws from.
int lens_margin(double blur);

// The share of a sub-pixel's light that falls on a pixel: the pixel's square and the lens's Gaussian, folded. One
// weight a sub-pixel of a pixel and its margin to both sides, (2 lens_margin(blur) + 1) kSubPixels, of sum 1.
std::vector<float> lens_kernel(double blur);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_LENS_KERNEL_H
