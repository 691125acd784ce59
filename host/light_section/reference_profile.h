// What a reference is: the section of a part, and what each camera column sees of it.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_REFERENCE_PROFILE_H
#define SELFPROJ_HOST_LIGHT_SECTION_REFERENCE_PROFILE_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace selfproj {

// The section of a reference part with the plane x = 0: points (0, y, z) in the camera's frame, mm. Neighbours are
// joined by straight lines, with two exceptions. A NaN between them is a gap without surface. A join steeper than
// kSteepest is a wall, which hides what is behind it but carries neither light nor reference.
struct ReferenceCurve {
  std::vector<double> y_mm;
  std::vector<double> z_mm;
};

// The slope |dz / dy| above which a join is a wall: 72 degrees. A line of light on such a wall would run along the
// image column for as many rows as the wall is high, and would have no usable centroid.
inline constexpr double kSteepest = 3;

// One entry for each camera column. The light of a rig that is_pinholes() is tan_theta. Other rigs have line and slope
// in its place.
struct ReferenceProfile {
  std::vector<double> tan_theta;  // the light plane that the column sees
  std::vector<double> line;       // the projector line that it sees there; 0 for a laser
  std::vector<double> slope;      // by how many lines the light rises from one projector column to the next
  std::vector<double> z_mm;       // z of the reference surface where that plane meets it in this column
  std::vector<double> offset_px;  // row of that point less the middle row: 0 for a perfect self-projection, the
                                  // measured residual, or the whole distance of a straight line
  std::vector<std::uint8_t> valid;

  void resize(int columns) {
    const auto size = static_cast<std::size_t>(columns);
    tan_theta.resize(size);
    resize_common(size);
  }
  void resize_for_lenses(int columns) {
    const auto size = static_cast<std::size_t>(columns);
    line.resize(size);
    slope.resize(size);
    resize_common(size);
  }
  void resize_common(std::size_t size) {
    z_mm.resize(size);
    offset_px.resize(size);
    valid.resize(size);
  }
  [[nodiscard]] int columns() const { return static_cast<int>(valid.size()); }
  [[nodiscard]] int valid_columns() const {
    return static_cast<int>(std::count_if(valid.begin(), valid.end(), [](std::uint8_t v) { return v != 0; }));
  }
  bool operator==(const ReferenceProfile&) const = default;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_REFERENCE_PROFILE_H
