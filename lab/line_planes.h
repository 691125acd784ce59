// Pixels of the camera and lines of the projector by the renderer's pinholes, independent of the host's triangulation,
// which is measured with them.
#ifndef SELFPROJ_LAB_LINE_PLANES_H
#define SELFPROJ_LAB_LINE_PLANES_H

#include <cstddef>

#include "host/rig/rig.h"
#include "sim/scene/pinhole.h"

namespace selfproj {

// The point that a pixel (row by row, from 0) sees at depth z, mm.
inline Point3 point_of_pixel(const Rig& rig, std::size_t pixel, double z) {
  const auto columns = static_cast<std::size_t>(rig.camera.columns);
  const double scale = z * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const std::size_t row = pixel / columns;
  return {(static_cast<double>(row) - 0.5 * (rig.camera.rows - 1)) * scale,
          (static_cast<double>(pixel % columns) - 0.5 * (rig.camera.columns - 1)) * scale, z};
}

// The planes of light of the projector's lines (4.8). The rig must outlive them.
class LinePlanes {
 public:
  explicit LinePlanes(const Rig& rig) : rig_(&rig), projector_(Pinhole::of_projector(rig.projector)) {}

  // The depth, mm, at which the pixel's ray meets the plane of a line (from 0, with a fraction).
  [[nodiscard]] double z(std::size_t pixel, double line) const {
    const double middle = 0.5 * (rig_->projector.columns - 1);
    const Point3 up = projector_.ray({line, middle});
    const Point3 c = projector_.centre();
    const Point3 ray = point_of_pixel(*rig_, pixel, 1);
    // The plane of the line contains the projector's centre, the direction `up` and y. Its normal is (up.z, 0, -up.x).
    return (up.z * c.x - up.x * c.z) / (up.z * ray.x - up.x);
  }

  // The projector's point (line, column) that lights what a pixel sees at depth z.
  [[nodiscard]] PixelPoint light(std::size_t pixel, double z) const {
    return projector_.project(point_of_pixel(*rig_, pixel, z));
  }

 private:
  const Rig* rig_;
  Pinhole projector_;
};

}  // namespace selfproj

#endif  // SELFPROJ_LAB_LINE_PLANES_H
