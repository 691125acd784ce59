#include "sim/scene/brown_lens.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace selfproj {
namespace {

// d(r (1 + k1 r² + k2 r⁴ + k3 r⁶)) / dr
double radial_slope(const BrownLens::Coefficients& c, double r2) {
  return 1 + r2 * (3 * c.k1 + r2 * (5 * c.k2 + r2 * 7 * c.k3));
}

// The square of the angle's tangent at which the image begins to fold over.
double fold(const BrownLens::Coefficients& c) {
  constexpr double kStep = 1e-3;
  constexpr double kMost = 9;       // 72 degrees
  constexpr double kShallow = 0.1;  // leaves room for the tangential terms
  double r2 = 0;
  while (r2 < kMost && radial_slope(c, r2) > kShallow) {
    r2 += kStep;
  }
  return r2;
}

}  // namespace

BrownLens::BrownLens(const Coefficients& c)
    : c_(c),
      distorts_(c.k1 != 0 || c.k2 != 0 || c.p1 != 0 || c.p2 != 0 || c.k3 != 0),
      most_r2_(distorts_ ? fold(c) : kUnlimited) {}

Tangents BrownLens::distorted(Tangents ray) const {
  const double x = ray.across;
  const double y = ray.down;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (c_.k1 + r2 * (c_.k2 + r2 * c_.k3));
  return {x * radial + 2 * c_.p1 * x * y + c_.p2 * (r2 + 2 * x * x),
          y * radial + c_.p1 * (r2 + 2 * y * y) + 2 * c_.p2 * x * y};
}

// Newton's method with the exact derivatives. It ends when a step no longer changes the ray but in its last digits.
Tangents BrownLens::undistorted(Tangents image) const {
  if (!distorts_) {
    return image;
  }
  constexpr int kMostSteps = 50;
  constexpr double kLastDigits = 1e-30;  // of the square of the step
  Tangents ray = image;
  for (int i = 0; i < kMostSteps; ++i) {
    const double x = ray.across;
    const double y = ray.down;
    const double r2 = x * x + y * y;
    const double radial = 1 + r2 * (c_.k1 + r2 * (c_.k2 + r2 * c_.k3));
    const double slope = 2 * (c_.k1 + r2 * (2 * c_.k2 + r2 * 3 * c_.k3));  // of `radial`, by x is slope x
    const double xx = radial + slope * x * x + 2 * c_.p1 * y + 6 * c_.p2 * x;
    const double xy = slope * x * y + 2 * c_.p1 * x + 2 * c_.p2 * y;  // of x by y, and of y by x
    const double yy = radial + slope * y * y + 6 * c_.p1 * y + 2 * c_.p2 * x;
    const Tangents found = distorted(ray);
    const double dx = image.across - found.across;
    const double dy = image.down - found.down;
    const double determinant = xx * yy - xy * xy;
    const double step_x = (yy * dx - xy * dy) / determinant;
    const double step_y = (xx * dy - xy * dx) / determinant;
    ray = {x + step_x, y + step_y};
    if (step_x * step_x + step_y * step_y <= kLastDigits * (1 + r2) && sees(ray)) {
      return ray;
    }
  }
  throw std::invalid_argument(
      fmt::format("the lens shows no ray at the tangents ({:g}, {:g})", image.across, image.down));
}

double BrownLens::stretch(double reach) const {
  const double r2 = reach * reach;
  return r2 * (3 * std::abs(c_.k1) + r2 * (5 * std::abs(c_.k2) + r2 * 7 * std::abs(c_.k3))) +
         8 * reach * (std::abs(c_.p1) + std::abs(c_.p2));
}

}  // namespace selfproj
