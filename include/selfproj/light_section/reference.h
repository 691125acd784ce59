// The reference of a self-projected measurement: the section of a part; for each camera column its light plane, and
// what the plane meets; and the pattern of a section. Through pinholes, or through the whole geometry of a rig.
#ifndef SELFPROJ_LIGHT_SECTION_REFERENCE_H
#define SELFPROJ_LIGHT_SECTION_REFERENCE_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "selfproj/model/column_runs.h"
#include "selfproj/rig/rig.h"

namespace selfproj::rig {
class RigOptics;  // selfproj/rig/optics.h
struct LightSheet;
}  // namespace selfproj::rig

namespace selfproj::light_section {

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

// What of a column counts in an image. A line is elsewhere where something else counts.
struct Selection {
  model::Select select = model::Select::all;
  int gap = 0;
  model::RowWindow window = {};

  bool operator==(const Selection&) const = default;
};
inline Selection selection_of(const model::Measure& measure) { return {measure.select, measure.gap, measure.window}; }

// Why frames of `rows` rows that begin after `offset` rows of the sensor, and of which this counted, do not go with a
// reference: a text for an error message, empty if they do. Rows that a frame has not need not have counted in it.
std::string unlike_reference(const std::optional<Selection>& reference, const Selection& frames, int offset, int rows);

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
  // What counted in the images that it was found in; nothing if it was computed without images.
  std::optional<Selection> measured;

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

// The curve of heights (plane_z - z, mm) given for every camera column, NaN if there is none: column η sees the point
// with y = z tan β(η). Throws std::invalid_argument unless there are as many as the rig has columns.
ReferenceCurve curve_of_heights(const rig::Rig& rig, std::span<const double> height_mm);

// The curve of a measured reference. It continues by 8 columns on both sides of the image with the slope of the last 8,
// so that its pattern does not end where the camera's view ends; lens blur would dim the columns at the border. Throws
// std::invalid_argument if the reference has another number of columns than the rig.
ReferenceCurve curve_of_reference(const rig::Rig& rig, const ReferenceProfile& reference);

// The reference that each column sees when the pattern of `curve` is projected onto `curve`: the surface nearest to the
// camera along tan β, with tan θ = x0 / (z - z0) (3.8) and offset 0. A column is invalid if there is no surface, a wall
// is nearer, the projector's light does not reach it (another part of the curve shades it, assuming that the part does
// not change along x, or it is outside the projector's image), or one projector line is worth more than
// max_z_per_line_mm.
ReferenceProfile reference_of_curve(const rig::Rig& rig, const ReferenceCurve& curve);

// The reference of the rig's empty table or conveyor: that of the heights 0.
ReferenceProfile reference_of_plane(const rig::Rig& rig);

// The reference of the conventional method, a straight line at the projector line `line`. tan θ is the same for every
// column. The line meets the reference at `centroid` (C, rows from 1, one for each camera column, NaN if there is
// none), and z follows by (3.4). Throws std::invalid_argument if the number of centroids is wrong.
ReferenceProfile reference_of_straight_line(const rig::Rig& rig, double line, std::span<const double> centroid);

// The reference with its residual taken out. `centroid` (as above) is where the pattern was seen when it was projected
// onto the reference part itself. If that is not the middle row, the light plane of the column is a little off. It must
// meet the reference (at z_mm) at that row:
//     tan θ = (x0 - x) / (z_r - z0),   x = z_r tan α(C)
// Columns without a centroid become invalid. Throws std::invalid_argument if the number of centroids, or of the
// reference's columns, is wrong.
ReferenceProfile without_residual(const rig::Rig& rig, const ReferenceProfile& reference,
                                  std::span<const double> centroid);

// The pattern has a jump at each wall of the reference, and columns beside it see light of both sides. It stays where
// it is when a part is shifted, and then falls on a surface; so many columns beside it count as without a point.
inline constexpr double kBesideWalls = 3.5;

// The reference for parts that may lie elsewhere: columns within kBesideWalls columns of a wall or gap at which the
// light changes become invalid.
ReferenceProfile without_walls(const rig::Rig& rig, ReferenceProfile reference);

// The curve's pattern by (3.9): for each of the rig's projector columns the line of the projector image, from 0 with a
// fraction, NaN for no light. At a step of the curve a column lights the surface nearest to the camera that both
// projector and camera see, and nothing if that is a wall. The line then has a gap and a jump, and nothing bridges it.
std::vector<double> pattern_of_curve(const rig::Rig& rig, const ReferenceCurve& curve);

// The rays of the camera's middle row, of any rig.
class MiddleRow {
 public:
  explicit MiddleRow(const rig::Rig& rig);

  // y / z of a column from 0, also beyond the image; NaN where the lens model folds over.
  [[nodiscard]] double tan_beta(double column) const;

 private:
  rig::RigCamera camera_;
  std::shared_ptr<const rig::RigOptics> optics_;  // null: pinholes
};

// The reference of columns that saw the projector line `line` (from 0, with a fraction; NaN: none) on the middle row,
// as a scan finds them: z_r by (3.8), offset 0. Throws std::invalid_argument if the number of lines is wrong.
ReferenceProfile reference_of_scan(const rig::Rig& rig, std::span<const double> line);

// The sheet of light through the reference of a column of a rig that is more than pinholes. Nothing if the reference is
// not valid there, or the projector cannot light it.
std::optional<rig::LightSheet> sheet_of(const rig::RigOptics& optics, const ReferenceProfile& reference, int column);

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_REFERENCE_H
