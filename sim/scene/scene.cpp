#include "sim/scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"

namespace selfproj::sim {
namespace {

Point3 lower(Point3 a, Point3 b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Point3 upper(Point3 a, Point3 b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

double square(double a) { return a * a; }

// Returns the squared distance of a point from a straight line.
double distance_2(const Ray& line, Point3 p) {
  const Point3 d = p - line.from;
  const double along = dot(d, line.along);
  return dot(d, d) - along * along / dot(line.along, line.along);
}

// Computes where the straight line of a ray enters and leaves a ball around the origin. Returns false if it misses the
// ball.
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

Body::Body(double albedo) : albedo_(albedo) {
  if (!(albedo >= 0 && albedo <= 1)) {
    throw std::invalid_argument("a body's albedo is not 0..1");
  }
}

Ellipsoid::Ellipsoid(Point3 centre, const std::array<Point3, 3>& axes, Point3 half, double albedo)
    : Body(albedo),
      centre_(centre),
      longest_(std::max({half.x, half.y, half.z})),
      to_sphere_{1 / half.x * axes[0], 1 / half.y * axes[1], 1 / half.z * axes[2]} {
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

bool Ellipsoid::is_near(const Ray& line, double slack) const {
  return distance_2(line, centre_) <= square(longest_ + slack);
}

Cuboid Ellipsoid::bounds() const { return bounds_; }

Capsule::Capsule(Point3 a, Point3 b, double radius, double albedo) : Body(albedo), a_(a), b_(b), radius_(radius) {
  if (!(radius > 0)) {
    throw std::invalid_argument("a capsule's radius is not > 0");
  }
}

// If the ray enters the infinite cylinder between the two ends, it enters the capsule there, through the side. If it
// enters the infinite cylinder beyond an end, it can enter the capsule only through the ball at this end.
bool Capsule::meets(const Ray& ray, double most, Meeting& meeting) const {
  const Point3 axis = b_ - a_;
  const double length_2 = dot(axis, axis);
  const Point3 from = ray.from - a_;
  const double from_along = length_2 > 0 ? dot(from, axis) / length_2 : 0;
  const double along_along = length_2 > 0 ? dot(ray.along, axis) / length_2 : 0;
  const Point3 across = ray.along - along_along * axis;
  double s = 0;
  double leaves = 0;
  double place = along_along > 0 ? -1 : 2;  // for a ray along the axis
  if (through_ball(from - from_along * axis, across, radius_ * radius_, s, leaves)) {
    place = from_along + s * along_along;
  } else if (dot(across, across) > 0) {
    return false;  // it misses even the infinite cylinder
  }
  Point3 nearest = a_ + place * axis;  // the nearest point of the axis
  if (place < 0 || place > 1) {
    nearest = place < 0 ? a_ : b_;
    if (!through_ball(ray.from - nearest, ray.along, radius_ * radius_, s, leaves)) {
      return false;
    }
  }
  if (!(s > 0 && s < most)) {
    return false;
  }
  meeting = {s, 1 / radius_ * (ray.from + s * ray.along - nearest)};
  return true;
}

// Compares radius + slack with the shortest distance between the straight line and the axis, which ends at a and b.
bool Capsule::is_near(const Ray& line, double slack) const {
  const Point3 axis = b_ - a_;
  const Point3 from = a_ - line.from;
  const double ll = dot(line.along, line.along);
  // The components perpendicular to the line. Its distance from the point a + u axis is |from_up + u axis_up|.
  const Point3 from_up = from - dot(from, line.along) / ll * line.along;
  const Point3 axis_up = axis - dot(axis, line.along) / ll * line.along;
  const double aa = dot(axis_up, axis_up);
  const double u = aa > 0 ? std::clamp(-dot(from_up, axis_up) / aa, 0.0, 1.0) : 0;
  const Point3 d = from_up + u * axis_up;
  return dot(d, d) <= square(radius_ + slack);
}

Cuboid Capsule::bounds() const {
  const Point3 r{radius_, radius_, radius_};
  return {lower(a_, b_) - r, upper(a_, b_) + r};
}

Block::Block(const Cuboid& box, double albedo) : Body(albedo), box_(box) {
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

bool Block::is_near(const Ray& line, double slack) const {
  const Point3 middle = 0.5 * (box_.low + box_.high);
  const Point3 half = 0.5 * (box_.high - box_.low);
  return distance_2(line, middle) <= square(std::sqrt(dot(half, half)) + slack);
}

namespace {

int frames_of(const rig::Rig& rig, double length) {
  const double step = rig.conveyor.speed_mm_per_s / rig.camera.frame_rate_hz;
  constexpr double kMost = 1e6;
  return step > 0 ? static_cast<int>(std::clamp(std::round((length + 2 * ConveyedScene::kLead) / step), 1.0, kMost))
                  : 1;
}

}  // namespace

ConveyedScene::ConveyedScene(const rig::Rig& rig, double length)
    : speed_(rig.conveyor.speed_mm_per_s),
      start_(speed_ > 0 ? -(length / 2 + kLead) : 0),
      frames_(frames_of(rig, length)) {}

}  // namespace selfproj::sim
