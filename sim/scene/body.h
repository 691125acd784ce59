// Bodies that hang in the air, as they stand at one instant. World frame of host/rig/rig.h, mm.
#ifndef SELFPROJ_SIM_SCENE_BODY_H
#define SELFPROJ_SIM_SCENE_BODY_H

#include <array>
#include <memory>
#include <vector>

#include "sim/scene/pinhole.h"

namespace selfproj {

// The points from + s along, s > 0; `along` may have any length.
struct Ray {
  Point3 from;
  Point3 along;
};

// Where a ray meets a body.
struct Meeting {
  double s = 0;
  Point3 normal;  // of the body, outwards, of length 1
};

// A box along the axes, bounds included.
struct Cuboid {
  Point3 low;
  Point3 high;
};

// A convex body, or a surface that throws no shadow. May be called by several threads at once.
class Body {
 public:
  Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  virtual ~Body() = default;

  // Whether the ray enters the body at 0 < s < most, and where.
  [[nodiscard]] virtual bool meets(const Ray& ray, double most, Meeting& meeting) const = 0;

  // Whether the body keeps light from coming along the ray between s = 0 and s = most.
  [[nodiscard]] virtual bool blocks(const Ray& ray, double most) const = 0;

  // False only where the straight line of the ray, to both sides without end, nowhere comes as near to the body as
  // `slack` mm.
  [[nodiscard]] virtual bool is_near(const Ray& line, double slack) const = 0;

  // Where all of it is.
  [[nodiscard]] virtual Cuboid bounds() const = 0;

  // Share of light that it throws back, evenly in all directions, 0..1.
  [[nodiscard]] virtual double albedo() const { return 1; }
};

using Bodies = std::vector<std::unique_ptr<Body>>;

// Half-axes along three directions at right angles, each of length 1.
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
  double longest_;                   // half-axis
  std::array<Point3, 3> to_sphere_;  // rows of the map to the ball of radius 1
  Cuboid bounds_;
  double albedo_;
};

// All points not further than `radius` from the straight line from a to b: fingers, arms.
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

// Along the axes.
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
