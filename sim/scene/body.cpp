#include "sim/scene/body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "sim/scene/pinhole.h"

namespace selfproj {
namespace {

Point3 lower(Point3 a, Point3 b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Point3 upper(Point3 a, Point3 b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

double checked_albedo(double albedo) {
  if (!(albedo >= 0 && albedo <= 1)) {
    throw std::invalid_argument("a body's albedo is not 0..1");
  }
  return albedo;
}

// Of the ball of radius 1 about the origin: where a ray enters and leaves it.
bool through_ball(Point3 from, Point3 along, double radius_2, double& enters, double& leaves) {
  const double a = dot(along, along);
  const double b = dot(from, along);
  const double c = dot(from, from) - radius_2;
  const double d = b * b - a * c;
  if (!(d > 0)) {
    return false;
  }
  const double root = std::sqrt(d);
  enters = (-b - root) / a;
  leaves = (-b + root) / a;
  return true;
}

}  // namespace

Ellipsoid::Ellipsoid(Point3 centre, const std::array<Point3, 3>& axes, Point3 half, double albedo)
    : centre_(centre),
      to_sphere_{1 / half.x * axes[0], 1 / half.y * axes[1], 1 / half.z * axes[2]},
      albedo_(checked_albedo(albedo)) {
  if (!(half.x > 0 && half.y > 0 && half.z > 0)) {
    throw std::invalid_argument("an ellipsoid's half-axis is not > 0");
  }
  const auto reach = [&](double a, double b, double c) {
    return std::sqrt(a * a * half.x * half.x + b * b * half.y * half.y + c * c * half.z * half.z);
  };
  const Point3 most{reach(axes[0].x, axes[1].x, axes[2].x), reach(axes[0].y, axes[1].y, axes[2].y),
                    reach(axes[0].z, axes[1].z, axes[2].z)};
  bounds_ = {centre - most, centre + most};
}

bool Ellipsoid::enters(const Ray& ray, double& s, double& leaves) const {
  const Point3 d = ray.from - centre_;
  const auto map = [&](Point3 p) {
    return Point3{dot(to_sphere_[0], p), dot(to_sphere_[1], p), dot(to_sphere_[2], p)};
  };
  return through_ball(map(d), map(ray.along), 1, s, leaves);
}

bool Ellipsoid::meets(const Ray& ray, double most, Meeting& meeting) const {
  double s = 0;
  double leaves = 0;
  if (!enters(ray, s, leaves) || !(s > 0 && s < most)) {
    return false;
  }
  // The normal is the gradient of |map(p)|².
  const Point3 p = ray.from + s * ray.along - centre_;
  const Point3 gradient = dot(to_sphere_[0], p) * to_sphere_[0] + dot(to_sphere_[1], p) * to_sphere_[1] +
                          dot(to_sphere_[2], p) * to_sphere_[2];
  meeting = {s, 1 / std::sqrt(dot(gradient, gradient)) * gradient};
  return true;
}

bool Ellipsoid::blocks(const Ray& ray, double most) const {
  double s = 0;
  double leaves = 0;
  return enters(ray, s, leaves) && leaves > 0 && s < most;
}

Cuboid Ellipsoid::bounds() const { return bounds_; }

Capsule::Capsule(Point3 a, Point3 b, double radius, double albedo)
    : a_(a), b_(b), radius_(radius), albedo_(checked_albedo(albedo)) {
  if (!(radius > 0)) {
    throw std::invalid_argument("a capsule's radius is not > 0");
  }
}

// The nearest of its two balls and its cylinder: the hull of the balls is convex, so that the first of their surfaces
// that belongs to it is where the ray enters.
bool Capsule::meets(const Ray& ray, double most, Meeting& meeting) const {
  double best = most;
  Point3 nearest;  // of the axis
  bool found = false;
  const Point3 axis = b_ - a_;
  const double length_2 = dot(axis, axis);
  if (length_2 > 0) {
    const Point3 from = ray.from - a_;
    const double from_along = dot(from, axis) / length_2;
    const double along_along = dot(ray.along, axis) / length_2;
    double s = 0;
    double leaves = 0;
    const Point3 across = ray.along - along_along * axis;
    const bool through = through_ball(from - from_along * axis, across, radius_ * radius_, s, leaves);
    if (!through && dot(across, across) > 0) {
      return false;  // not even the endless cylinder
    }
    if (through && s > 0 && s < best) {
      const double place = from_along + s * along_along;
      if (place >= 0 && place <= 1) {
        best = s;
        nearest = a_ + place * axis;
        found = true;
      }
    }
  }
  for (const Point3& end : {a_, b_}) {
    double s = 0;
    double leaves = 0;
    if (through_ball(ray.from - end, ray.along, radius_ * radius_, s, leaves) && s > 0 && s < best) {
      best = s;
      nearest = end;
      found = true;
    }
  }
  if (found) {
    meeting = {best, 1 / radius_ * (ray.from + best * ray.along - nearest)};
  }
  return found;
}

bool Capsule::blocks(const Ray& ray, double most) const {
  Meeting unused;
  return meets(ray, most, unused);
}

Cuboid Capsule::bounds() const {
  const Point3 r{radius_, radius_, radius_};
  return {lower(a_, b_) - r, upper(a_, b_) + r};
}

Block::Block(const Cuboid& box, double albedo) : box_(box), albedo_(checked_albedo(albedo)) {
  if (!(box.low.x < box.high.x && box.low.y < box.high.y && box.low.z < box.high.z)) {
    throw std::invalid_argument("a block's low corner is not below its high one");
  }
}

bool Block::meets(const Ray& ray, double most, Meeting& meeting) const {
  const std::array<double, 3> from{ray.from.x, ray.from.y, ray.from.z};
  const std::array<double, 3> along{ray.along.x, ray.along.y, ray.along.z};
  const std::array<double, 3> low{box_.low.x, box_.low.y, box_.low.z};
  const std::array<double, 3> high{box_.high.x, box_.high.y, box_.high.z};
  double enters = -std::numeric_limits<double>::infinity();
  double leaves = std::numeric_limits<double>::infinity();
  std::size_t face = 0;
  for (std::size_t i = 0; i < low.size(); ++i) {
    if (along[i] == 0) {
      if (from[i] < low[i] || from[i] > high[i]) {
        return false;
      }
      continue;
    }
    double in = (low[i] - from[i]) / along[i];
    double out = (high[i] - from[i]) / along[i];
    if (in > out) {
      std::swap(in, out);
    }
    if (in > enters) {
      enters = in;
      face = i;
    }
    leaves = std::min(leaves, out);
  }
  if (!(enters < leaves && enters > 0 && enters < most)) {
    return false;
  }
  std::array<double, 3> normal{};
  normal[face] = along[face] > 0 ? -1 : 1;
  meeting = {enters, {normal[0], normal[1], normal[2]}};
  return true;
}

bool Block::blocks(const Ray& ray, double most) const {
  Meeting unused;
  return meets(ray, most, unused);
}

}  // namespace selfproj
