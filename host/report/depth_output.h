// Depth images as pictures, clouds and tables.
#ifndef SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H
#define SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H

#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/depth_shares.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

// mm that a unit of the 16-bit picture is worth.
inline constexpr double kDepthUnit = 0.05;

// PNG of 16 bits: depth / kDepthUnit, rounded, 0 where there is none; depths of more than 65535 units are 65535.
std::string depth_png(const FloatImage& depth);

// The picture in colours with bar and scale as PNG; scale bars are for the median depth in the middle of the image.
std::string depth_picture(const Triangulation& triangulation, const FloatImage& depth, const std::string& title);

// The points that have a depth, in the order of the pixels, and the same as PLY in the colours of the picture.
std::vector<Point3f> points_of(const Triangulation& triangulation, const FloatImage& depth);
std::string cloud_ply(const Triangulation& triangulation, const FloatImage& depth);

// pair,valid,not_measurable,...: a line a depth image.
std::string shares_csv(const std::vector<OfImage<DepthShares>>& shares);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H
