#include "sim/scene/planted_part.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace selfproj::sim {
namespace {

constexpr double kHalfPart = PlantedPart::kLength / 2;

double square(double x, double y) { return x * x + y * y; }

// The squares of the least and the greatest distance of a rectangle's points from a point.
std::pair<double, double> square_distances(const Box& box, double u, double w) {
  const double du = std::max({box.x0 - u, 0.0, u - box.x1});
  const double dw = std::max({box.y0 - w, 0.0, w - box.y1});
  return {square(du, dw), square(std::max(std::abs(box.x0 - u), std::abs(box.x1 - u)),
                                 std::max(std::abs(box.y0 - w), std::abs(box.y1 - w)))};
}

}  // namespace

PlantedPart::PlantedPart(const rig::Rig& rig, const PartPose& pose, std::vector<PlantedDefect> defects)
    : ConveyedScene(rig, kLength),
      pose_(pose),
      cos_(std::cos(pose.turn_deg * std::numbers::pi / 180)),
      sin_(std::sin(pose.turn_deg * std::numbers::pi / 180)),
      defects_(std::move(defects)) {}

// (u, w) are the axes of the part: u along the belt, w across.
double PlantedPart::part_height(double x, double y) const {
  const double u = (x - pose_.along_mm) * cos_ + (y - pose_.across_mm) * sin_;
  const double w = (y - pose_.across_mm) * cos_ - (x - pose_.along_mm) * sin_;
  if (std::abs(u) > kHalfPart || std::abs(w) > kTreadWidth) {
    return 0;
  }
  double height = tread_height(w);
  for (const PlantedDefect& defect : defects_) {
    const double distance = square(kHalfPart - u - defect.along, w - defect.across);
    height -= distance <= square(defect.size / 2, 0) ? defect.depth : 0;
  }
  return height;
}

HeightRange PlantedPart::part_range(const Box& box) const {
  // The rectangle in the axes of the part that contains the turned box.
  const double x = (box.x0 + box.x1) / 2 - pose_.along_mm;
  const double y = (box.y0 + box.y1) / 2 - pose_.across_mm;
  const double half_x = (box.x1 - box.x0) / 2;
  const double half_y = (box.y1 - box.y0) / 2;
  const double half_u = half_x * cos_ + half_y * std::abs(sin_);
  const double half_w = half_y * cos_ + half_x * std::abs(sin_);
  const double u = x * cos_ + y * sin_;
  const double w = y * cos_ - x * sin_;
  const Box own{u - half_u, u + half_u, w - half_w, w + half_w};
  if (own.x0 > kHalfPart || own.x1 < -kHalfPart || own.y0 > kTreadWidth || own.y1 < -kTreadWidth) {
    return {0, 0};
  }
  const bool inside = own.x0 >= -kHalfPart && own.x1 <= kHalfPart && own.y0 >= -kTreadWidth && own.y1 <= kTreadWidth;
  HeightRange range{tread_height(own.y0), tread_height(own.y0)};
  range.join(tread_height(own.y1));
  for (const PlantedDefect& defect : defects_) {
    const auto [least, greatest] = square_distances(own, kHalfPart - defect.along, defect.across);
    const double rim = square(defect.size / 2, 0);
    if (least > rim) {
      continue;
    }
    const double bottom = kTreads.at(defect.tread) - defect.depth;
    if (greatest <= rim) {
      return {bottom, bottom};
    }
    range.join(bottom);
  }
  if (!inside) {
    range.join(0);
  }
  return range;
}

}  // namespace selfproj::sim
