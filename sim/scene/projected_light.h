// The light from the projector: its pattern, blurred by its lens, also between its pixels.
#ifndef SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H
#define SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H

#include <cstddef>
#include <optional>
#include <vector>

#include "host/images/float_image.h"
#include "sim/scene/defocus.h"
#include "sim/scene/min_max_pyramid.h"
#include "sim/scene/pinhole.h"

namespace selfproj {

// A projector's lens that is sharp at one distance. It maps z of the world to the blur at a place of the pattern.
struct ProjectorFocus {
  FocusedLens lens;
  Pinhole projector;  // its distortion does not matter here
  double nearest_z;   // mm: the blur is prepared from here to the farthest
  double farthest_z;

  // Standard deviation of the blur, in pixels.
  [[nodiscard]] double sigma_px(double line, double column, double z) const;
};

class ProjectedLight {
 public:
  // `pattern` has light 0..1, projector lines x columns; `blur` is the standard deviation in pixels. With a focus the
  // blur grows with the distance from it.
  ProjectedLight(const FloatImage& pattern, double blur, const std::optional<ProjectorFocus>& focus = {});

  // The light at a place of the pattern: linear between the centres of the blurred pixels, 0 outside.
  [[nodiscard]] double at(PixelPoint p) const;

  // The same where it falls on something at z, mm.
  [[nodiscard]] double at(PixelPoint p, double z) const { return focus_ ? focused_at(p, z) : at(p); }
  [[nodiscard]] float quick_at(float line, float column, float z) const {
    return focus_ ? static_cast<float>(
                        focused_at({static_cast<double>(line), static_cast<double>(column)}, static_cast<double>(z)))
                  : quick_at(line, column);
  }

  // The light of the blurred pattern, without defocus, in a part of it: sum and middle, and how many pixels have light.
  struct Part {
    double sum;
    double pixels;
    PixelPoint middle;
  };
  [[nodiscard]] Part in(int first_line, int last_line, int first_column, int last_column) const;

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

  // Bounds of line_centre between two columns; nothing if a column there has no light.
  struct Centres {
    double low, high;
  };
  [[nodiscard]] std::optional<Centres> line_centres(double first, double last) const;

 private:
  int margin_;        // dark or blurred pixels around the pattern
  FloatImage light_;  // with the margin
  MinMaxPyramid ranges_;
  std::vector<double> centres_;

  [[nodiscard]] double focused_at(PixelPoint p, double z) const;
  std::optional<ProjectorFocus> focus_;
  double blur_ = 0;
  double variance_step_ = 0;           // from one of the wider ones to the next
  std::vector<ProjectedLight> wider_;  // with more and more blur
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H
