// The effect of the camera's lens and of its square pixels on an image of sub-pixels.
#ifndef SELFPROJ_SIM_SCENE_LENS_KERNEL_H
#define SELFPROJ_SIM_SCENE_LENS_KERNEL_H

#include <vector>

namespace selfproj {

// Sub-pixels along a side of a pixel.
inline constexpr int kSubPixels = 4;

// The width in pixels of the margin from which a lens with this Gaussian blur (standard deviation in pixels) gathers
// light.
int lens_margin(double blur);

// The share of a sub-pixel's light that falls on a pixel: the pixel's square, folded with the lens's Gaussian. There is
// one weight for each sub-pixel of a pixel and of its margin on both sides, (2 lens_margin(blur) + 1) kSubPixels, of
// sum 1.
std::vector<float> lens_kernel(double blur);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_LENS_KERNEL_H
