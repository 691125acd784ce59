// The reference of a self-projected measurement: for each camera column its light plane, and what the plane meets.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_REFERENCE_H
#define SELFPROJ_HOST_LIGHT_SECTION_REFERENCE_H

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/light_section/reference_profile.h"
#include "host/rig/rig.h"

namespace selfproj {

// The curve of heights (plane_z - z, mm) given for every camera column, NaN if there is none: column η sees the point
// with y = z tan β(η). Throws std::invalid_argument unless there are as many as the rig has columns.
ReferenceCurve curve_of_heights(const Rig& rig, std::span<const double> height_mm);

// The curve of a measured reference. It continues by 8 columns on both sides of the image with the slope of the last 8,
// so that its pattern does not end where the camera's view ends; lens blur would dim the columns at the border.
ReferenceCurve curve_of_reference(const Rig& rig, const ReferenceProfile& reference);

// The reference that each column sees when the pattern of `curve` is projected onto `curve`: the surface nearest to the
// camera along tan β, with tan θ = x0 / (z - z0) (3.8) and offset 0. A column is invalid if there is no surface, a wall
// is nearer, the projector's light does not reach it (another part of the curve shades it, assuming that the part does
// not change along x, or it is outside the projector's image), or one projector line is worth more than
// max_z_per_line_mm.
ReferenceProfile reference_of_curve(const Rig& rig, const ReferenceCurve& curve);

// The reference of the rig's empty table or conveyor.
ReferenceProfile reference_of_plane(const Rig& rig);

// The reference of the conventional method, a straight line at the projector line `line`. tan θ is the same for every
// column. The line meets the reference at `centroid` (C, rows from 1, one for each camera column, NaN if there is
// none), and z follows by (3.4). Throws std::invalid_argument if the number of centroids is wrong.
ReferenceProfile reference_of_straight_line(const Rig& rig, double line, std::span<const double> centroid);

// The reference with its residual taken out. `centroid` (as above) is where the pattern was seen when it was projected
// onto the reference part itself. If that is not the middle row, the light plane of the column is a little off. It must
// meet the reference (at z_mm) at that row:
//     tan θ = (x0 - x) / (z_r - z0),   x = z_r tan α(C)
// Columns without a centroid become invalid. Throws std::invalid_argument if the number of centroids is wrong.
ReferenceProfile without_residual(const Rig& rig, const ReferenceProfile& reference, std::span<const double> centroid);

// The curve's pattern by (3.9): for each projector column the line of the projector image, from 0 with a fraction, NaN
// for no light. At a step of the curve a column lights the surface nearest to the camera that both projector and camera
// see, and nothing if that is a wall. The line then has a gap and a jump, and nothing bridges it.
std::vector<double> pattern_of_curve(const Rig& rig, const ReferenceCurve& curve);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_REFERENCE_H
