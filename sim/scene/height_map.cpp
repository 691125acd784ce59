#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

images::FloatImage without_nan(images::FloatImage image) {
  std::replace_if(
      image.values.begin(), image.values.end(), [](float value) { return std::isnan(value); }, 0.0F);
  return image;
}

class HeightMap : public ConveyedScene {
 public:
  // The map must have pixels, and the scale must be positive. Throws UserError if heights are infinite or not below the
  // camera and the projector.
  HeightMap(const images::FloatImage& height_mm, double mm_per_pixel, const rig::Rig& rig, const std::string& source);

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
  images::FloatImage heights_;  // without NaN
  MinMaxPyramid ranges_;
};

}  // namespace

HeightMap::HeightMap(const images::FloatImage& height_mm, double mm_per_pixel, const rig::Rig& rig,
                     const std::string& source)
    : ConveyedScene(rig, height_mm.rows * mm_per_pixel),
      scale_(mm_per_pixel),
      half_length_(height_mm.rows * mm_per_pixel / 2),
      half_width_(height_mm.columns * mm_per_pixel / 2),
      heights_(without_nan(height_mm)),
      ranges_(heights_) {
  const MinMaxPyramid::Range all = ranges_.range(0, heights_.rows - 1, 0, heights_.columns - 1);
  const double limit = rig.plane_z_mm - std::max(0.0, rig.projector.z_mm);
  if (!std::isfinite(all.low) || static_cast<double>(all.high) >= limit) {
    throw UserError(source,
                    fmt::format("has heights from {} to {} mm; they must be finite and below {} mm, where camera "
                                "and projector are",
                                all.low, all.high, limit));
  }
}

double HeightMap::at(double row, double column) const {
  const double r = std::clamp(row, 0.0, heights_.rows - 1.0);
  const double c = std::clamp(column, 0.0, heights_.columns - 1.0);
  const int r0 = static_cast<int>(r);
  const int c0 = static_cast<int>(c);
  const int r1 = std::min(r0 + 1, heights_.rows - 1);
  const int c1 = std::min(c0 + 1, heights_.columns - 1);
  const double fr = r - r0;
  const double fc = c - c0;
  const float* above = heights_.row(r0);
  const float* below = heights_.row(r1);
  return (1 - fr) * ((1 - fc) * static_cast<double>(above[c0]) + fc * static_cast<double>(above[c1])) +
         fr * ((1 - fc) * static_cast<double>(below[c0]) + fc * static_cast<double>(below[c1]));
}

double HeightMap::part_height(double x, double y) const {
  return std::abs(x) <= half_length_ && std::abs(y) <= half_width_ ? at(row_of(x), column_of(y)) : 0;
}

HeightRange HeightMap::part_range(const Box& box) const {
  const Box inner{std::max(box.x0, -half_length_), std::min(box.x1, half_length_), std::max(box.y0, -half_width_),
                  std::min(box.y1, half_width_)};
  if (inner.x0 > inner.x1 || inner.y0 > inner.y1) {
    return {0, 0};
  }
  const auto inside = [](double value, int size) { return std::clamp(value, 0.0, size - 1.0); };
  const double r0 = inside(row_of(inner.x1), heights_.rows);
  const double r1 = inside(row_of(inner.x0), heights_.rows);
  const double c0 = inside(column_of(inner.y0), heights_.columns);
  const double c1 = inside(column_of(inner.y1), heights_.columns);
  HeightRange result{};
  if (std::floor(r1) - std::floor(r0) <= 1 && std::floor(c1) - std::floor(c0) <= 1) {
    // Between the centres of four pixels the height has its extremes in the corners of the rectangle and where the
    // rectangle passes a centre.
    const std::array<double, 3> rows{r0, std::max(r0, std::floor(r1)), r1};
    const std::array<double, 3> columns{c0, std::max(c0, std::floor(c1)), c1};
    result = {std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()};
    for (const double r : rows) {
      for (const double c : columns) {
        result.join(at(r, c));
      }
    }
  } else {
    const MinMaxPyramid::Range range = ranges_.range(static_cast<int>(r0), static_cast<int>(std::ceil(r1)),
                                                     static_cast<int>(c0), static_cast<int>(std::ceil(c1)));
    result = {static_cast<double>(range.low), static_cast<double>(range.high)};
  }
  const bool all_inside = inner.x0 == box.x0 && inner.x1 == box.x1 && inner.y0 == box.y0 && inner.y1 == box.y1;
  if (!all_inside) {
    result.join(0);
  }
  return result;
}

std::unique_ptr<Scene> height_map_scene(const images::FloatImage& height_mm, double mm_per_pixel, const rig::Rig& rig,
                                        const std::string& source) {
  if (height_mm.values.empty()) {
    throw UserError(source, "has no pixels");
  }
  if (!(mm_per_pixel > 0) || !std::isfinite(mm_per_pixel)) {
    throw UserError(source, fmt::format("has a scale of {} mm a pixel; it must be greater than 0", mm_per_pixel));
  }
  return std::make_unique<HeightMap>(height_mm, mm_per_pixel, rig, source);
}

}  // namespace selfproj::sim
