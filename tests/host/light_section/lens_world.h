// A rig with lenses on both sides, written out apart from the host's own geometry: pixels of points by the formulas of
// OpenCV's lens model, and the places where camera columns see the light on a surface by search.
#ifndef SELFPROJ_TESTS_HOST_LIGHT_SECTION_LENS_WORLD_H
#define SELFPROJ_TESTS_HOST_LIGHT_SECTION_LENS_WORLD_H

#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <span>
#include <vector>

#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "tests/host/rig/random_lens.h"

namespace selfproj::test {

// How a rig differs from the pinholes of a built-in one.
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;  // of both lenses
  cv::Vec3d turn{0, 0, 0};                // degrees, of the projector against the camera, about each axis in turn
  cv::Vec3d move{0, 0, 0};                // mm
};

inline cv::Matx33d turned(const cv::Vec3d& degrees) {
  cv::Matx33d result = cv::Matx33d::eye();
  for (int axis = 0; axis < 3; ++axis) {
    const double angle = degrees[axis] * 3.14159265358979323846 / 180;
    cv::Matx33d turn = cv::Matx33d::eye();
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    turn(a, a) = turn(b, b) = std::cos(angle);
    turn(b, a) = std::sin(angle);
    turn(a, b) = -turn(b, a);
    result = turn * result;
  }
  return result;
}

// The full model of a rig, changed.
inline rig::Calibration distorted_calibration(const rig::Rig& rig, const Distortion& d) {
  rig::Calibration c = rig::calibration_of(rig);
  for (rig::Lens* lens : {&c.camera, &c.projector}) {
    lens->k = {d.k1, d.k2, d.p1, d.p2, 0, 0, 0, 0};
  }
  c.rotation = turned(d.turn) * c.rotation;
  c.translation += d.move;
  return c;
}

// Axes are those of the calibration: x along columns, y along rows.
class LensWorld {
 public:
  explicit LensWorld(const rig::Calibration& calibration) : c_(calibration) {}

  // (column, row) and (column, line).
  [[nodiscard]] cv::Vec2d camera(const cv::Vec3d& x) const { return pixel(c_.camera, x); }
  [[nodiscard]] cv::Vec2d projector(const cv::Vec3d& x) const {
    return pixel(c_.projector, c_.rotation * x + c_.translation);
  }

  // The point of the surface z(y along columns, x along rows) that camera column `column` sees in the light of the line
  // line(projector column).
  [[nodiscard]] cv::Vec3d lit_point(double column, const std::function<double(double, double)>& surface,
                                    const std::function<double(double)>& line) const {
    cv::Vec2d at(0, 0);
    const auto point = [&](const cv::Vec2d& p) { return cv::Vec3d(p[0], p[1], surface(p[0], p[1])); };
    const auto off = [&](const cv::Vec2d& p) {
      const cv::Vec2d lit = projector(point(p));
      return cv::Vec2d(camera(point(p))[0] - column, lit[1] - line(lit[0]));
    };
    constexpr double kStep = 1e-4;
    for (int i = 0; i < 40; ++i) {
      const cv::Vec2d here = off(at);
      const cv::Vec2d by_x = (off(at + cv::Vec2d(kStep, 0)) - here) / kStep;
      const cv::Vec2d by_y = (off(at + cv::Vec2d(0, kStep)) - here) / kStep;
      const cv::Vec2d step = cv::Matx22d(by_x[0], by_y[0], by_x[1], by_y[1]).inv() * here;
      at -= step;
      if (std::abs(step[0]) + std::abs(step[1]) < 1e-9) {
        break;
      }
    }
    return point(at);
  }

 private:
  static cv::Vec2d pixel(const rig::Lens& lens, const cv::Vec3d& x) {
    const auto [column, row] = distorted(lens, x[0] / x[2], x[1] / x[2]);
    return {column, row};
  }

  rig::Calibration c_;
};

// The pattern of a whole image as a function: linear between the columns.
inline std::function<double(double)> between(const std::vector<double>& lines) {
  return [lines](double column) {
    const auto i = static_cast<std::size_t>(std::floor(column));
    const double t = column - std::floor(column);
    return column >= 0 && i + 1 < lines.size() ? lines[i] + t * (lines[i + 1] - lines[i])
                                               : std::numeric_limits<double>::quiet_NaN();
  };
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_LIGHT_SECTION_LENS_WORLD_H
