// The light that the projector throws: its pattern, blurred by its lens, anywhere between its pixels.
#ifndef SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H
#define SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H

#include <vector>

#include "host/io/float_image.h"
#include "sim/scene/min_max_pyramid.h"
#include "sim/scene/pinhole.h"

namespace selfproj {

// The weights of a Gaussian of standard deviation `sigma` at whole steps, -4 sigma to 4 sigma, of sum 1.
std::vector<double> gaussian_kernel(double sigma);

class ProjectedLight {
 public:
  // A pattern of light 0..1, projector lines x columns, and the standard deviation of the blur in pixels.
  ProjectedLight(const FloatImage& pattern, double blur);

  // The light at a place of the pattern: linear between the centres of the blurred pixels, 0 beyond the pattern.
  [[nodiscard]] double at(PixelPoint p) const;

  // Whether no place in the rectangle is lit.
  [[nodiscard]] bool is_dark(double line_0, double line_1, double column_0, double column_1) const;

  // The middle of the line at this column: the centroid of the pattern's light (without blur), linear between columns.
  // NaN where a column has none.
  [[nodiscard]] double line_centre(double column) const;

 private:
  int margin_;        // dark or blurred pixels around the pattern
  FloatImage light_;  // with the margin
  MinMaxPyramid ranges_;
  std::vector<double> centres_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H
