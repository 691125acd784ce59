// Depth images as files: what `selfproj depth` leaves behind (README.md beside this file has the formats).
#ifndef SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H
#define SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

// How many pixels of a depth image have each state.
struct DepthShares {
  std::array<std::size_t, kPointStates> count{};

  [[nodiscard]] std::size_t of(PointState state) const { return count[static_cast<std::size_t>(state)]; }
  [[nodiscard]] std::size_t total() const;
};
DepthShares count_states(const std::vector<PointState>& states);

// "valid", "not_measurable", ...: as in summary.json.
const char* name_of(PointState state);

// mm that a unit of the 16-bit picture is worth.
inline constexpr double kDepthUnit = 0.05;

// PNG of 16 bits: depth / kDepthUnit, rounded, 0 where there is none; depths of more than 65535 units are 65535.
std::string depth_png(const FloatImage& depth);

// The picture in colours with bar and scale; scale bars are for the median depth in the middle of the image.
// `rows_are_x` names the axes: a rig's image rows run along x, a calibrated camera's along y.
std::string depth_picture(const Triangulation& triangulation, const FloatImage& depth, bool rows_are_x,
                          const std::string& title);

// The points that have a depth, in the order of the pixels, and the same as PLY in the colours of the picture.
std::vector<Point3f> points_of(const Triangulation& triangulation, const FloatImage& depth);
std::string cloud_ply(const Triangulation& triangulation, const FloatImage& depth);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H
