#include "sim/scene/vibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace selfproj {
namespace {

class SwingingBelt final : public Scene {
 public:
  SwingingBelt(const Scene& scene, const Vibration& vibration)
      : scene_(scene), amplitude_(vibration.belt_mm), pulsation_(2 * std::numbers::pi * vibration.belt_hz) {}
  [[nodiscard]] int frames() const override { return scene_.frames(); }
  [[nodiscard]] double height(double x, double y, double t) const override { return scene_.height(x, y, t) + swing(t); }
  // The swing's bounds over the time are those of a straight line through its middle of the greatest slope.
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override {
    const HeightRange range = scene_.range(box, t0, t1);
    const double middle = swing((t0 + t1) / 2);
    const double off = std::min(amplitude_ * pulsation_ * (t1 - t0) / 2, 2 * amplitude_);
    return {range.low + middle - off, range.high + middle + off};
  }
  [[nodiscard]] double albedo(double x, double y, double t) const override { return scene_.albedo(x, y, t); }
  [[nodiscard]] bool even_albedo() const override { return scene_.even_albedo(); }
  [[nodiscard]] bool has_exact_levels() const override { return scene_.has_exact_levels(); }
  [[nodiscard]] double speed() const override { return scene_.speed(); }
  [[nodiscard]] Bodies bodies(double t) const override { return scene_.bodies(t); }
  [[nodiscard]] double body_speed() const override { return scene_.body_speed(); }

 private:
  [[nodiscard]] double swing(double t) const { return amplitude_ * std::sin(pulsation_ * t); }

  const Scene& scene_;
  double amplitude_;
  double pulsation_;
};

// Weights of the four pixels around a place that is `f` after the second of them (Keys 1981, a = -1/2).
std::array<float, 4> cubic(double f) {
  return {static_cast<float>(((-0.5 * f + 1) * f - 0.5) * f), static_cast<float>((1.5 * f - 2.5) * f * f + 1),
          static_cast<float>(((-1.5 * f + 2) * f + 0.5) * f), static_cast<float>((0.5 * f - 0.5) * f * f)};
}

}  // namespace

std::unique_ptr<Scene> on_swinging_belt(const Scene& scene, const Vibration& vibration) {
  return std::make_unique<SwingingBelt>(scene, vibration);
}

ImageShift camera_shift(const Vibration& vibration, double t) {
  const double phase = 2 * std::numbers::pi * vibration.camera_hz * t;
  return {vibration.camera_px * std::sin(phase), vibration.camera_px * std::cos(phase)};
}

void move_image(int rows, int columns, ImageShift shift, std::span<float> pixels) {
  const auto pass = [&](std::span<const float> from, std::span<float> to, bool down, double by) {
    const int whole = static_cast<int>(std::floor(-by));
    const std::array<float, 4> weights = cubic(-by - whole);
    const int last = (down ? rows : columns) - 1;
    const std::ptrdiff_t step = down ? columns : 1;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(r) * columns + c;
        const int place = down ? r : c;
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
          const int at = std::clamp(place + whole - 1 + k, 0, last);
          sum += weights.at(static_cast<std::size_t>(k)) * from[static_cast<std::size_t>(i + (at - place) * step)];
        }
        to[static_cast<std::size_t>(i)] = sum;
      }
    }
  };
  std::vector<float> half(pixels.size());
  pass(pixels, half, true, shift.rows);
  pass(half, pixels, false, shift.columns);
}

}  // namespace selfproj
