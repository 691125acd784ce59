// Depth images as pictures, clouds and tables.
#ifndef SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H
#define SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H

#include <string>
#include <vector>

#include "host/images/float_image.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/depth_shares.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

// Millimetres for one unit of the 16-bit picture.
inline constexpr double kDepthUnit = 0.05;

// 16-bit PNG: depth / kDepthUnit, rounded; 0 if there is no depth; depths of more than 65535 units become 65535.
std::string depth_png(const FloatImage& depth);

// The picture in colours with colour bar and scale bars, as PNG. Scale bars hold for the median depth in the middle of
// the image.
std::string depth_picture(const Triangulation& triangulation, const FloatImage& depth, const std::string& title);

// The points that have a depth, in the order of the pixels; and the same as PLY in the colours of the picture.
std::vector<Point3f> points_of(const Triangulation& triangulation, const FloatImage& depth);
std::string cloud_ply(const Triangulation& triangulation, const FloatImage& depth);

// One line for each depth image: pair,valid,not_measurable,...
std::string shares_csv(const std::vector<OfImage<DepthShares>>& shares);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H
