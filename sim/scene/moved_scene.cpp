#include "sim/scene/moved_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "selfproj/files/user_error.h"

namespace selfproj::sim {
namespace {

const ConveyedScene& conveyed(const Scene& scene, const std::string& options) {
  const auto* const part = dynamic_cast<const ConveyedScene*>(&scene);
  if (part == nullptr) {
    throw UserError(options, "the scene is no part on a conveyor");
  }
  return *part;
}

}  // namespace

MovedScene::MovedScene(const Scene& scene, const Displacement& displacement, const std::string& options)
    : WrappedScene(scene),
      part_(conveyed(scene, options)),
      lift_(displacement.lift_mm),
      aside_(displacement.aside_mm),
      cos_(std::cos(displacement.turn_deg * std::numbers::pi / 180)),
      sin_(std::sin(displacement.turn_deg * std::numbers::pi / 180)) {}

MovedScene::Place MovedScene::place(double x, double y, double middle) const {
  const double dx = x - middle;
  const double dy = y - aside_;
  return {middle + cos_ * dx + sin_ * dy, cos_ * dy - sin_ * dx};
}

Box MovedScene::box_of(const Box& box, double middle) const {
  const Place a = place(box.x0, box.y0, middle);
  const Place b = place(box.x1, box.y0, middle);
  const Place c = place(box.x0, box.y1, middle);
  const Place d = place(box.x1, box.y1, middle);
  const auto [x0, x1] = std::minmax({a.x, b.x, c.x, d.x});
  const auto [y0, y1] = std::minmax({a.y, b.y, c.y, d.y});
  return {x0, x1, y0, y1};
}

double MovedScene::height(double x, double y, double t) const {
  const Place at = place(x, y, part_.position(t));
  return lifted(part_.height(at.x, at.y, t));
}

HeightRange MovedScene::range(const Box& box, double t0, double t1) const {
  // The middle moves evenly, so that the places of a corner lie between those of the first and the last moment.
  const Box first = box_of(box, part_.position(t0));
  const Box last = box_of(box, part_.position(t1));
  const HeightRange inside = part_.range({std::min(first.x0, last.x0), std::max(first.x1, last.x1),
                                          std::min(first.y0, last.y0), std::max(first.y1, last.y1)},
                                         t0, t1);
  if (inside.high <= 0) {
    return inside;
  }
  if (inside.low > 0) {
    return {inside.low + lift_, inside.high + lift_};
  }
  return {std::min(inside.low, inside.low + lift_), std::max(inside.high + lift_, 0.0)};  // plane and part
}

double MovedScene::albedo(double x, double y, double t) const {
  const Place at = place(x, y, part_.position(t));
  return part_.albedo(at.x, at.y, t);
}

}  // namespace selfproj::sim
