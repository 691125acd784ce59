#include "host/structured_light/plane_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "host/io/float_image.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {
namespace {

// Calls `what(pixel, point)` for the pixels that have a depth.
template <typename What>
void for_each_point(const Triangulation& triangulation, const FloatImage& depth, const What& what) {
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    if (!std::isnan(depth.values[i])) {
      const Point3f at = triangulation.point(i, depth.values[i]);
      what(i, cv::Vec3d(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)));
    }
  }
}

}  // namespace

PlaneFit fit_plane(const Triangulation& triangulation, const FloatImage& depth) {
  if (depth.rows != triangulation.rows() || depth.columns != triangulation.columns()) {
    throw std::invalid_argument("plane fit: the depth image has another size than the triangulation");
  }
  PlaneFit fit;
  cv::Vec3d mean;
  for_each_point(triangulation, depth, [&](std::size_t, const cv::Vec3d& point) {
    ++fit.points;
    mean += point;
  });
  if (fit.points < 3) {
    return fit;
  }
  const auto count = static_cast<double>(fit.points);
  mean /= count;
  // Relative to the mean, so that the normal equations of a, b are well scaled and z0 separates.
  cv::Matx22d square;
  cv::Vec2d with_z;
  for_each_point(triangulation, depth, [&](std::size_t, const cv::Vec3d& point) {
    const cv::Vec3d offset = point - mean;
    const cv::Vec2d across(offset[0], offset[1]);
    square += across * across.t();
    with_z += across * offset[2];
  });
  constexpr double kOnALine = 1e-12;  // of the sum of both extents squared, squared
  if (!(cv::determinant(square) > kOnALine * cv::trace(square) * cv::trace(square))) {
    return fit;
  }
  const cv::Vec2d slope = square.inv(cv::DECOMP_CHOLESKY) * with_z;
  fit.a = slope[0];
  fit.b = slope[1];
  fit.z0 = mean[2] - slope.dot({mean[0], mean[1]});
  double squares = 0;
  double rounding = 0;
  fit.greatest = 0;
  for_each_point(triangulation, depth, [&](std::size_t i, const cv::Vec3d& point) {
    const double residual = point[2] - fit.z0 - slope.dot({point[0], point[1]});
    squares += residual * residual;
    fit.greatest = std::max(fit.greatest, std::abs(residual));
    const double of_code = triangulation.rounding_error(i, depth.values[i]);
    rounding += of_code * of_code;
  });
  fit.rms = std::sqrt(squares / count);
  fit.rounding_rms = std::sqrt(rounding / count);
  return fit;
}

}  // namespace selfproj
