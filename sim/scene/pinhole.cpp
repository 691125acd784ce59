#include "sim/scene/pinhole.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "host/rig/rig.h"

namespace selfproj {
namespace {

// Grows to hold all points that are added to it.
class Bounds {
 public:
  void add(double row, double column) {
    b_ = {std::min(b_.row_0, row), std::max(b_.row_1, row), std::min(b_.column_0, column),
          std::max(b_.column_1, column)};
  }
  [[nodiscard]] const PixelBounds& all() const { return b_; }

 private:
  static constexpr double kMost = std::numeric_limits<double>::max();
  PixelBounds b_{kMost, -kMost, kMost, -kMost};
};

}  // namespace

Pinhole::Pinhole(Point3 centre, const std::array<Point3, 3>& axes, const Intrinsics& k, const BrownLens& lens)
    : centre_(centre), axes_(axes), k_(k), lens_(lens) {
  // K R: each row is the direction of a pixel axis, scaled, plus the optical axis times the principal point.
  const std::array<Point3, 3> kr{k.row_scale * axes[0] + k.row_0 * axes[2],
                                 k.column_scale * axes[1] + k.column_0 * axes[2], axes[2]};
  for (std::size_t i = 0; i < kr.size(); ++i) {
    matrix_[i] = {kr[i].x, kr[i].y, kr[i].z, -dot(kr[i], centre)};
  }
}

Pinhole Pinhole::of_camera(const RigCamera& camera) {
  const double scale = camera.focal_length_mm / camera.pixel_pitch_mm;
  return {{0, 0, 0},
          {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
          {scale, scale, (camera.rows - 1) / 2.0, (camera.columns - 1) / 2.0}};
}

// The axis, tilted from z towards −x, is (−sin θ0, 0, cos θ0). Xp grows in the direction in which it turns as θ0 grows.
Pinhole Pinhole::of_projector(const RigProjector& projector) {
  const double s = std::sin(projector.tilt_rad);
  const double c = std::cos(projector.tilt_rad);
  return {{projector.x_mm, 0, projector.z_mm},
          {{{-c, 0, -s}, {0, 1, 0}, {-s, 0, c}}},
          {projector.focal_length_mm / projector.line_pitch_mm, projector.focal_length_mm / projector.column_pitch_mm,
           (projector.lines - 1) / 2.0 - projector.center_xp_mm / projector.line_pitch_mm,
           (projector.columns - 1) / 2.0 - projector.center_yp_mm / projector.column_pitch_mm}};
}

Tangents Pinhole::tangents_of(Point3 p) const {
  const Point3 from = p - centre_;
  const double w = 1 / dot(axes_[2], from);
  return {dot(axes_[1], from) * w, dot(axes_[0], from) * w};
}

PixelPoint Pinhole::project_distorted(Point3 p) const {
  const Tangents ray = tangents_of(p);
  if (!lens_.sees(ray)) {
    constexpr double kFar = -1e6;
    return {kFar, kFar};
  }
  return pixel_of(lens_.distorted(ray));
}

Point3 Pinhole::ray(PixelPoint pixel) const {
  const Tangents ray =
      lens_.undistorted({(pixel.column - k_.column_0) / k_.column_scale, (pixel.row - k_.row_0) / k_.row_scale});
  return ray.down * axes_[0] + ray.across * axes_[1] + axes_[2];
}

std::array<Point3, 4> Pinhole::corner_sights(PixelPoint first, PixelPoint last) const {
  const double bend = lens_.distorts() ? kBend : 0;
  return {sight({first.row - bend, first.column - bend}), sight({first.row - bend, last.column + bend}),
          sight({last.row + bend, first.column - bend}), sight({last.row + bend, last.column + bend})};
}

// Without distortion the image of a convex body is convex, so its corners bound it. With distortion they bound its
// tangents; the lens then displaces each of these as it displaces the rectangle's middle, but for the stretch.
std::optional<PixelBounds> Pinhole::bounds(std::span<const Point3> points) const {
  if (std::any_of(points.begin(), points.end(), [&](Point3 p) { return depth(p) <= 0; })) {
    return std::nullopt;
  }
  Bounds result;
  if (!lens_.distorts()) {
    for (const Point3 p : points) {
      const PixelPoint pixel = project(p);
      result.add(pixel.row, pixel.column);
    }
    return result.all();
  }
  Bounds rays;  // rows are `down`, columns `across`
  for (const Point3 p : points) {
    const Tangents ray = tangents_of(p);
    rays.add(ray.down, ray.across);
  }
  const PixelBounds& r = rays.all();
  const Tangents middle{(r.column_0 + r.column_1) / 2, (r.row_0 + r.row_1) / 2};
  const Tangents moved = lens_.distorted(middle);
  const double reach =
      std::hypot(std::max(std::abs(r.row_0), std::abs(r.row_1)), std::max(std::abs(r.column_0), std::abs(r.column_1)));
  const double slack = lens_.stretch(reach) * std::hypot(r.row_1 - middle.down, r.column_1 - middle.across);
  for (const double down : {r.row_0 - slack, r.row_1 + slack}) {
    for (const double across : {r.column_0 - slack, r.column_1 + slack}) {
      const PixelPoint pixel = pixel_of({across + moved.across - middle.across, down + moved.down - middle.down});
      result.add(pixel.row, pixel.column);
    }
  }
  return result.all();
}

}  // namespace selfproj
