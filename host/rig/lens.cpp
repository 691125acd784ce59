#include "host/rig/lens.h"

#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

namespace selfproj {

cv::Vec2d Lens::pixel(const cv::Vec2d& ray) const {
  cv::Matx22d unused;
  return pixel(ray, unused);
}

cv::Vec2d Lens::pixel(const cv::Vec2d& ray, cv::Matx22d& derivative) const {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = k;
  const double x = ray[0];
  const double y = ray[1];
  const double s = x * x + y * y;
  const double above = 1 + s * (k1 + s * (k2 + s * k3));
  const double below = 1 + s * (k4 + s * (k5 + s * k6));
  const double q = above / below;
  // dq/ds
  const double slope = ((k1 + s * (2 * k2 + s * 3 * k3)) - q * (k4 + s * (2 * k5 + s * 3 * k6))) / below;
  const double across = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  derivative = {fx * (q + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x), fx * across,  //
                fy * across, fy * (q + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x)};
  return {fx * (x * q + 2 * p1 * x * y + p2 * (s + 2 * x * x)) + cx,
          fy * (y * q + p1 * (s + 2 * y * y) + 2 * p2 * x * y) + cy};
}

std::optional<cv::Vec2d> Lens::ray(const cv::Vec2d& pixel) const {
  constexpr int kSteps = 30;
  constexpr double kClose = 1e-9;  // pixels
  cv::Vec2d ray((pixel[0] - cx) / fx, (pixel[1] - cy) / fy);
  for (int step = 0; step < kSteps; ++step) {
    cv::Matx22d derivative;
    const cv::Vec2d off = this->pixel(ray, derivative) - pixel;
    // Beyond the place where the image folds over, another ray falls on the same pixel; a real lens has none there.
    if (!(cv::determinant(derivative) * fx * fy > 0)) {
      return std::nullopt;
    }
    if (std::abs(off[0]) + std::abs(off[1]) < kClose) {
      return ray;
    }
    ray -= derivative.inv() * off;
  }
  return std::nullopt;
}

}  // namespace selfproj
