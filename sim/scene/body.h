// Bodies in the air at one instant. World frame of host/rig/rig.h, mm.
#ifndef SELFPROJ_SIM_SCENE_BODY_H
#define SELFPROJ_SIM_SCENE_BODY_H

#include <array>
#include <memory>
#include <vector>

#include "sim/scene/pinhole.h"

namespace selfproj {

// The points from + s along with s > 0; `along` may have any length.
struct Ray {
  Point3 from;
  Point3 along;
};

// Where a ray meets a body.
struct Meeting {
  double s = 0;
  Point3 normal;  // outward normal of the body, of length 1
};

// A box with sides along the axes, bounds included.
struct Cuboid {
  Point3 low;
  Point3 high;
};

// A convex body, or a surface that throws no shadow. Several threads may call it at once.
class Body {
 public:
  Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  virtual ~Body() = default;

  // Whether the ray enters the body at 0 < s < most, and where.
  [[nodiscard]] virtual bool meets(const Ray& ray, double most, Meeting& meeting) const = 0;

  // Whether the body blocks light along the ray between s = 0 and s = most.
  [[nodiscard]] virtual bool blocks(const Ray& ray, double most) const = 0;

  // False only if the straight line of the ray, extended to both sides, nowhere comes within `slack` mm of the body.
  [[nodiscard]] virtual bool is_near(const Ray& line, double slack) const = 0;

  // A box that contains the body.
  [[nodiscard]] virtual Cuboid bounds() const = 0;

  // The share of light that it scatters, evenly in all directions, 0..1.
  [[nodiscard]] virtual double albedo() const { return 1; }
};

using Bodies = std::vector<std::unique_ptr<Body>>;

// An ellipsoid with half-axes along three perpendicular directions of length 1.
class Ellipsoid final : public Body {
 public:
  Ellipsoid(Point3 centre, const std::array<Point3, 3>& axes, Point3 half, double albedo = 1);
  [[nodiscard]] bool meets(const Ray& ray, double most, Meeting& meeting) const override;
  [[nodiscard]] bool blocks(const Ray& ray, double most) const override;
  [[nodiscard]] bool is_near(const Ray& line, double slack) const override;
  [[nodiscard]] Cuboid bounds() const override;
  [[nodiscard]] double albedo() const override { return albedo_; }

 private:
  [[nodiscard]] bool enters(const Ray& ray, double& s, double& leaves) const;

  Point3 centre_;
  double longest_;                   // longest half-axis
  std::array<Point3, 3> to_sphere_;  // rows of the map to the unit ball
  Cuboid bounds_;
  double albedo_;
};

// All points within `radius` of the straight line from a to b: fingers, arms.
class Capsule final : public Body {
 public:
  Capsule(Point3 a, Point3 b, double radius, double albedo = 1);
  [[nodiscard]] bool meets(const Ray& ray, double most, Meeting& meeting) const override;
  [[nodiscard]] bool blocks(const Ray& ray, double most) const override;
  [[nodiscard]] bool is_near(const Ray& line, double slack) const override;
  [[nodiscard]] Cuboid bounds() const override;
  [[nodiscard]] double albedo() const override { return albedo_; }

 private:
  Point3 a_, b_;
  double radius_;
  double albedo_;
};

// A box with sides along the axes.
class Block final : public Body {
 public:
  explicit Block(const Cuboid& box, double albedo = 1);
  [[nodiscard]] bool meets(const Ray& ray, double most, Meeting& meeting) const override;
  [[nodiscard]] bool blocks(const Ray& ray, double most) const override;
  [[nodiscard]] bool is_near(const Ray& line, double slack) const override;
  [[nodiscard]] Cuboid bounds() const override { return box_; }
  [[nodiscard]] double albedo() const override { return albedo_; }

 private:
  Cuboid box_;
  double albedo_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BODY_H
