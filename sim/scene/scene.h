// A scene: a surface given by its height above the plane, which may move and change with time, and bodies in the air
// before it. World frame of include/selfproj/rig/rig.h, mm.
#ifndef SELFPROJ_SIM_SCENE_SCENE_H
#define SELFPROJ_SIM_SCENE_SCENE_H

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"

namespace selfproj::sim {

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
  // `albedo` is the share of light that it scatters, evenly in all directions. Throws std::invalid_argument outside
  // 0..1.
  explicit Body(double albedo = 1);
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  virtual ~Body() = default;

  // Whether the ray enters the body at 0 < s < most, and where.
  [[nodiscard]] virtual bool meets(const Ray& ray, double most, Meeting& meeting) const = 0;

  // Whether the body blocks light along the ray between s = 0 and s = most.
  [[nodiscard]] virtual bool blocks(const Ray& ray, double most) const {
    Meeting unused;
    return meets(ray, most, unused);
  }

  // False only if the straight line of the ray, extended to both sides, nowhere comes within `slack` mm of the body.
  [[nodiscard]] virtual bool is_near(const Ray& line, double slack) const = 0;

  // A box that contains the body.
  [[nodiscard]] virtual Cuboid bounds() const = 0;

  [[nodiscard]] double albedo() const { return albedo_; }

 private:
  double albedo_;
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

 private:
  [[nodiscard]] bool enters(const Ray& ray, double& s, double& leaves) const;

  Point3 centre_;
  double longest_;                   // longest half-axis
  std::array<Point3, 3> to_sphere_;  // rows of the map to the unit ball
  Cuboid bounds_;
};

// All points within `radius` of the straight line from a to b: fingers, arms.
class Capsule final : public Body {
 public:
  Capsule(Point3 a, Point3 b, double radius, double albedo = 1);
  [[nodiscard]] bool meets(const Ray& ray, double most, Meeting& meeting) const override;
  [[nodiscard]] bool is_near(const Ray& line, double slack) const override;
  [[nodiscard]] Cuboid bounds() const override;

 private:
  Point3 a_, b_;
  double radius_;
};

// A box with sides along the axes.
class Block final : public Body {
 public:
  explicit Block(const Cuboid& box, double albedo = 1);
  [[nodiscard]] bool meets(const Ray& ray, double most, Meeting& meeting) const override;
  [[nodiscard]] bool is_near(const Ray& line, double slack) const override;
  [[nodiscard]] Cuboid bounds() const override { return box_; }

 private:
  Cuboid box_;
};

// A rectangle of the plane, bounds included, mm.
struct Box {
  double x0, x1;
  double y0, y1;
};

// Bounds of the heights over a rectangle, mm.
struct HeightRange {
  double low, high;

  void join(double height) { *this = {std::min(low, height), std::max(high, height)}; }
  void join(HeightRange other) { *this = {std::min(low, other.low), std::max(high, other.high)}; }
};

// Bounds of the first, second and third derivative of the height along any direction: 1, 1/mm, 1/mm².
struct Smoothness {
  double slope = std::numeric_limits<double>::infinity();
  double curvature = std::numeric_limits<double>::infinity();
  double change = std::numeric_limits<double>::infinity();  // of the curvature
};

// A surface z = plane_z − height(x, y, t) over the whole plane. A jump of the height is a vertical face. World frame of
// include/selfproj/rig/rig.h, mm; t in seconds, 0 at the middle of frame 0's exposure. Several threads may call all
// functions at once.
class Scene {
 public:
  Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  virtual ~Scene() = default;

  // The number of frames that show everything that happens.
  [[nodiscard]] virtual int frames() const = 0;

  // Height above the plane, towards the camera.
  [[nodiscard]] virtual double height(double x, double y, double t) const = 0;

  // Bounds of the height over the rectangle and over t0 <= t <= t1. They need not be sharp, but must converge to the
  // height as rectangle and time shrink to a point without a jump, because rays are intersected by them.
  [[nodiscard]] virtual HeightRange range(const Box& box, double t0, double t1) const = 0;

  // Whether range gives the very numbers that height gives wherever the surface is level.
  [[nodiscard]] virtual bool has_exact_levels() const { return true; }

  // The share of light that the surface scatters, evenly in all directions, 0..1.
  [[nodiscard]] virtual double albedo(double /*x*/, double /*y*/, double /*t*/) const { return 1; }

  // Whether the albedo is the same everywhere at all times.
  [[nodiscard]] virtual bool even_albedo() const { return true; }

  // How smooth the surface is over the rectangle, and whether its albedo is the same all over it, at all times. What is
  // known to be smooth and plain is rendered faster.
  [[nodiscard]] virtual Smoothness smoothness(const Box& /*box*/) const { return {}; }
  [[nodiscard]] virtual bool is_plain(const Box& /*box*/) const { return even_albedo(); }

  // The greatest speed of any part of the surface, mm/s.
  [[nodiscard]] virtual double speed() const = 0;

  // Bodies in front of the surface at the time t, which may hover and move: always the same number in the same order,
  // at most kMaxBodies. Only the renderer of whole patterns (pattern_renderer.h) shows them.
  [[nodiscard]] virtual Bodies bodies(double /*t*/) const { return {}; }
  static constexpr std::size_t kMaxBodies = 32;

  // The greatest speed of any point of a body, mm/s.
  [[nodiscard]] virtual double body_speed() const { return 0; }
};

// Another scene, but for what a derived class changes. That scene must live as long.
class WrappedScene : public Scene {
 public:
  explicit WrappedScene(const Scene& scene) : scene_(scene) {}
  [[nodiscard]] int frames() const override { return scene_.frames(); }
  [[nodiscard]] double height(double x, double y, double t) const override { return scene_.height(x, y, t); }
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override {
    return scene_.range(box, t0, t1);
  }
  [[nodiscard]] bool has_exact_levels() const override { return scene_.has_exact_levels(); }
  [[nodiscard]] double albedo(double x, double y, double t) const override { return scene_.albedo(x, y, t); }
  [[nodiscard]] bool even_albedo() const override { return scene_.even_albedo(); }
  [[nodiscard]] Smoothness smoothness(const Box& box) const override { return scene_.smoothness(box); }
  [[nodiscard]] bool is_plain(const Box& box) const override { return scene_.is_plain(box); }
  [[nodiscard]] double speed() const override { return scene_.speed(); }
  [[nodiscard]] Bodies bodies(double t) const override { return scene_.bodies(t); }
  [[nodiscard]] double body_speed() const override { return scene_.body_speed(); }

 private:
  const Scene& scene_;
};

// A part, given in its own coordinates, on a conveyor that moves along +x: x_part = x − x_start − v t. Its middle is at
// x_part = 0, y = 0.
class ConveyedScene : public Scene {
 public:
  // The part, `length` mm along x, reaches x = 0 kLead mm after the first frame, and the last frame is as far behind
  // it. On a conveyor that stands still, it lies with its middle at x = 0, for one frame.
  ConveyedScene(const rig::Rig& rig, double length);

  [[nodiscard]] int frames() const override { return frames_; }
  [[nodiscard]] double height(double x, double y, double t) const final { return part_height(x - position(t), y); }
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const final {
    return part_range({box.x0 - position(t1), box.x1 - position(t0), box.y0, box.y1});
  }
  [[nodiscard]] double speed() const final { return speed_; }

  // x of the part's middle, mm.
  [[nodiscard]] double position(double t) const { return start_ + speed_ * t; }

  // The same functions in the part's coordinates; 0 beside the part.
  [[nodiscard]] virtual double part_height(double x_part, double y) const = 0;
  [[nodiscard]] virtual HeightRange part_range(const Box& part_box) const = 0;

  static constexpr double kLead = 5;  // mm

 private:
  double speed_;
  double start_;
  int frames_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_SCENE_H
