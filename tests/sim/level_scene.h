// A simple scene, images of it as numbers, and the closed forms of the method in its angles. They share nothing with
// the renderer's matrices and rays.
#ifndef SELFPROJ_TESTS_SIM_LEVEL_SCENE_H
#define SELFPROJ_TESTS_SIM_LEVEL_SCENE_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj::test {

// Options without any disturbance.
inline sim::RenderOptions ideal() {
  return {.shot_noise = false,
          .read_noise = false,
          .quantization = false,
          .camera_blur = false,
          .projector_blur = false,
          .motion_blur = false,
          .falloff = false};
}

// A level surface with a level block on it, which has a width along x and is endless along y.
class LevelScene : public sim::Scene {
 public:
  double floor = 0;                           // height beside the block
  double top = 0;                             // height of the block
  double x0 = 0;                              // the block begins here
  double x1 = -1;                             // and ends here, at t = 0
  double fastest = 0;                         // speed of the block along x, mm/s
  std::function<double(double)> reflectance;  // at x

  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double x, double /*y*/, double t) const override {
    return x >= x0 + fastest * t && x <= x1 + fastest * t ? top : floor;
  }
  [[nodiscard]] sim::HeightRange range(const sim::Box& b, double t0, double t1) const override {
    const bool on = x1 > x0 && b.x1 >= x0 + fastest * t0 && b.x0 <= x1 + fastest * t1;
    const bool off = !(x1 > x0 && b.x0 >= x0 + fastest * t1 && b.x1 <= x1 + fastest * t0);
    return {std::min(on ? top : floor, off ? floor : top), std::max(on ? top : floor, off ? floor : top)};
  }
  [[nodiscard]] double albedo(double x, double /*y*/, double /*t*/) const override {
    return reflectance ? reflectance(x) : 1;
  }
  [[nodiscard]] bool even_albedo() const override { return !reflectance; }
  [[nodiscard]] double speed() const override { return fastest; }
};

// A rendered frame.
struct Frame {
  int rows, columns;
  std::vector<float> pixels;

  Frame(const rig::Rig& rig, const sim::LineRenderer& renderer, int frame)
      : rows(rig.camera.rows),
        columns(rig.camera.columns),
        pixels(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns)) {
    renderer.render(frame, std::span<float>(pixels));
  }
  [[nodiscard]] double at(int row, int column) const {
    return static_cast<double>(
        pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)]);
  }
  [[nodiscard]] double sum(int column, double background) const {
    double sum = 0;
    for (int r = 0; r < rows; ++r) {
      sum += at(r, column) - background;
    }
    return sum;
  }
  // The row, from 0, of the centre of a column's light over `background`.
  [[nodiscard]] double centroid(int column, double background) const {
    double m1 = 0;
    for (int r = 0; r < rows; ++r) {
      m1 += (at(r, column) - background) * r;
    }
    return m1 / sum(column, background);
  }
};

// tan θ of a projector line (3.6, 3.7).
inline double tan_theta(const rig::Rig& rig, double line) {
  const rig::RigProjector& p = rig.projector;
  return std::tan(p.tilt_rad +
                  std::atan((p.center_xp_mm + p.line_pitch_mm * (line - (p.lines - 1) / 2.0)) / p.focal_length_mm));
}

// The projector line that meets (x, ., z).
inline double line_at(const rig::Rig& rig, double x, double z) {
  const rig::RigProjector& p = rig.projector;
  const double theta = std::atan2(p.x_mm - x, z - p.z_mm);
  return (p.focal_length_mm * std::tan(theta - p.tilt_rad) - p.center_xp_mm) / p.line_pitch_mm + (p.lines - 1) / 2.0;
}

inline double row_of(const rig::Rig& rig, double tan_alpha) {
  return tan_alpha * rig.camera.focal_length_mm / rig.camera.pixel_pitch_mm + (rig.camera.rows - 1) / 2.0;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SIM_LEVEL_SCENE_H
