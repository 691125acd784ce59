// The light from the projector: its pattern, blurred by its lens, also between its pixels.
#ifndef SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H
#define SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H

#include <vector>

#include "host/io/float_image.h"
#include "sim/scene/min_max_pyramid.h"
#include "sim/scene/pinhole.h"

namespace selfproj {

// The weights of a Gaussian of standard deviation `sigma` at integers from -4 sigma to 4 sigma, of sum 1.
std::vector<double> gaussian_kernel(double sigma);

class ProjectedLight {
 public:
  // `pattern` has light 0..1, projector lines x columns; `blur` is the standard deviation in pixels.
  ProjectedLight(const FloatImage& pattern, double blur);

  // The light at a place of the pattern: linear between the centres of the blurred pixels, 0 outside.
  [[nodiscard]] double at(PixelPoint p) const;

  // The same in 32-bit floats, for many places.
  [[nodiscard]] float quick_at(float line, float column) const {
    const float r = line + static_cast<float>(margin_);
    const float c = column + static_cast<float>(margin_);
    if (!(r > 0 && c > 0 && r < static_cast<float>(light_.rows - 1) && c < static_cast<float>(light_.columns - 1))) {
      return 0;
    }
    const int r0 = static_cast<int>(r);
    const int c0 = static_cast<int>(c);
    const float fr = r - static_cast<float>(r0);
    const float fc = c - static_cast<float>(c0);
    const float* above = light_.row(r0) + c0;
    const float* below = above + light_.columns;
    const float left = above[0] + fr * (below[0] - above[0]);
    const float right = above[1] + fr * (below[1] - above[1]);
    return left + fc * (right - left);
  }

  // Bounds of the light in the rectangle.
  [[nodiscard]] MinMaxPyramid::Range range(double line_0, double line_1, double column_0, double column_1) const;

  // Whether the whole rectangle is dark.
  [[nodiscard]] bool is_dark(double line_0, double line_1, double column_0, double column_1) const;

  // The middle of the line at this column: the centroid of the pattern's light without blur, linear between columns.
  // NaN for a column without light.
  [[nodiscard]] double line_centre(double column) const;

 private:
  int margin_;        // dark or blurred pixels around the pattern
  FloatImage light_;  // with the margin
  MinMaxPyramid ranges_;
  std::vector<double> centres_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H
