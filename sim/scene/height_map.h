// A part on the conveyor, given by a map of its heights.
#ifndef SELFPROJ_SIM_SCENE_HEIGHT_MAP_H
#define SELFPROJ_SIM_SCENE_HEIGHT_MAP_H

#include <memory>
#include <string>

#include "host/images/float_image.h"
#include "sim/scene/min_max_pyramid.h"
#include "sim/scene/scene.h"

namespace selfproj {

class HeightMap : public ConveyedScene {
 public:
  // The map must have pixels, and the scale must be positive. Throws UserError if heights are infinite or not below the
  // camera and the projector.
  HeightMap(const FloatImage& height_mm, double mm_per_pixel, const Rig& rig, const std::string& source);

  [[nodiscard]] double part_height(double x, double y) const override;
  [[nodiscard]] HeightRange part_range(const Box& box) const override;
  [[nodiscard]] bool has_exact_levels() const override { return false; }  // they are interpolated

 private:
  // A place in the map in pixels; 0 is the centre of the first pixel.
  [[nodiscard]] double row_of(double x) const { return (half_length_ - x) / scale_ - 0.5; }
  [[nodiscard]] double column_of(double y) const { return (half_width_ + y) / scale_ - 0.5; }

  // Linear between the centres of pixels, constant beyond the outermost ones.
  [[nodiscard]] double at(double row, double column) const;

  double scale_;
  double half_length_;
  double half_width_;
  FloatImage heights_;  // without NaN
  MinMaxPyramid ranges_;
};

// A part from a map of its heights above the plane, mm. The map is oriented like the measured heights: its first row
// reaches the line first (largest x), y grows with the column, and its middle is at y = 0. A pixel is a square with
// sides of mm_per_pixel and its height at its centre; between the centres heights are interpolated linearly. The map
// ends in vertical faces. NaN stands for the bare plane. Throws UserError about `source` if there are no pixels, the
// scale is not positive, or heights are not below the camera and the projector.
std::unique_ptr<Scene> height_map_scene(const FloatImage& height_mm, double mm_per_pixel, const Rig& rig,
                                        const std::string& source = "height map");

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_HEIGHT_MAP_H
