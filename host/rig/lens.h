// The lens of a camera or projector: a pinhole with the distortion model of OpenCV's calibration.
#ifndef SELFPROJ_HOST_RIG_LENS_H
#define SELFPROJ_HOST_RIG_LENS_H

#include <array>
#include <opencv2/core/matx.hpp>
#include <optional>

namespace selfproj {

// Focal lengths and centre are in pixels; pixel centres are integers from 0. The coefficients k1, k2, p1, p2, k3, k4,
// k5, k6 are those of OpenCV. The ray (x, y, 1) falls on pixel column fx x' + cx, row fy y' + cy, where
//
//     x' = x q + 2 p1 x y + p2 (r² + 2 x²)      q = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
//     y' = y q + p1 (r² + 2 y²) + 2 p2 x y      r² = x² + y²
struct Lens {
  double fx = 1;
  double fy = 1;
  double cx = 0;
  double cy = 0;
  std::array<double, 8> k{};

  // The pixel (column, row) of the ray (x, y, 1).
  [[nodiscard]] cv::Vec2d pixel(const cv::Vec2d& ray) const;

  // The same, and its derivative by x and y.
  [[nodiscard]] cv::Vec2d pixel(const cv::Vec2d& ray, cv::Matx22d& derivative) const;

  // The ray (x, y, 1) that falls on a pixel, to 1e-9 pixels. Far from the axis the distortion model may fold the image
  // over; rays from there do not count. Returns nothing if no other ray falls on this pixel.
  [[nodiscard]] std::optional<cv::Vec2d> ray(const cv::Vec2d& pixel) const;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_LENS_H
