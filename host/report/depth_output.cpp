#include "host/report/depth_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/files/numbers.h"
#include "host/report/colour_map.h"
#include "host/report/map_picture.h"
#include "host/structured_light/point_cloud.h"

namespace selfproj {
namespace {

// The median of the depths in mm; 1 if there is none.
float median_depth(const FloatImage& depth) {
  std::vector<float> values;
  std::copy_if(depth.values.begin(), depth.values.end(), std::back_inserter(values),
               [](float value) { return !std::isnan(value); });
  return values.empty() ? 1 : median_of(std::move(values));
}

double distance(const Point3f& a, const Point3f& b) {
  return std::hypot(static_cast<double>(a.x - b.x), static_cast<double>(a.y - b.y), static_cast<double>(a.z - b.z));
}

}  // namespace

std::string depth_png(const FloatImage& depth) {
  cv::Mat picture(depth.rows, depth.columns, CV_16UC1);
  for (int r = 0; r < depth.rows; ++r) {
    std::transform(depth.row(r), depth.row(r) + depth.columns, picture.ptr<std::uint16_t>(r), [](float z) {
      constexpr double kMost = 65535;
      return std::isnan(z)
                 ? std::uint16_t{0}
                 : static_cast<std::uint16_t>(std::lround(std::clamp(static_cast<double>(z) / kDepthUnit, 0.0, kMost)));
    });
  }
  std::vector<std::uint8_t> bytes;
  if (depth.values.empty() || !cv::imencode(".png", picture, bytes)) {
    throw std::runtime_error("depth.png: an image of this size cannot be written as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

std::string depth_picture(const Triangulation& triangulation, const FloatImage& depth, const std::string& title) {
  const float z = median_depth(depth);
  const auto columns = static_cast<std::size_t>(depth.columns);
  const std::size_t row = static_cast<std::size_t>(depth.rows) / 2 - (depth.rows > 1 ? 1 : 0);
  const std::size_t column = columns / 2 - (columns > 1 ? 1 : 0);
  const std::size_t at = row * columns + column;
  const Point3f middle = triangulation.point(at, z);
  const double down = depth.rows > 1 ? distance(middle, triangulation.point(at + columns, z)) : 1;
  const double right = columns > 1 ? distance(middle, triangulation.point(at + 1, z)) : 1;
  const bool rows_are_x = triangulation.rows_are_x();
  const MapPitch pitch{down, right, rows_are_x ? 'x' : 'y', rows_are_x ? 'y' : 'x'};
  return labelled_map_png(depth, height_scale(depth), pitch, title);
}

std::vector<Point3f> points_of(const Triangulation& triangulation, const FloatImage& depth) {
  std::vector<Point3f> points;
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    if (!std::isnan(depth.values[i])) {
      points.push_back(triangulation.point(i, depth.values[i]));
    }
  }
  return points;
}

std::string cloud_ply(const Triangulation& triangulation, const FloatImage& depth) {
  const std::vector<Point3f> points = points_of(triangulation, depth);
  const MapScale scale = height_scale(depth);
  PlyText ply(points.size());
  for (const Point3f& point : points) {
    const Colour colour = colour_at(scale.map, (static_cast<double>(point.z) - scale.low) / (scale.high - scale.low));
    ply.add(point, colour.red, colour.green, colour.blue);
  }
  return ply.file("millimetres, colour by z");
}

std::string shares_csv(const std::vector<OfImage<DepthShares>>& shares) {
  std::string text = "pair";
  for (int state = 0; state < kPointStates; ++state) {
    text += fmt::format(",{}", name_of(static_cast<PointState>(state)));
  }
  text += '\n';
  for (const OfImage<DepthShares>& image : shares) {
    fmt::format_to(std::back_inserter(text), "{},{}\n", image.number, fmt::join(image.value.count, ","));
  }
  return text;
}

}  // namespace selfproj
