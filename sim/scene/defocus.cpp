#include "sim/scene/defocus.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "sim/scene/gaussian_kernel.h"

namespace selfproj {
namespace {

constexpr double kSampled = 0.6;  // pixels; from here on a sampled Gaussian is right

// Weights for standard deviations in steps, made when they are first needed.
class Weights {
 public:
  const std::vector<float>& of(float sigma) {
    constexpr float kStepsPerPixel = 64;
    const auto step = static_cast<std::size_t>(std::lround(std::max(0.0F, sigma) * kStepsPerPixel));
    if (step >= all_.size()) {
      all_.resize(step + 1);
    }
    if (all_[step].empty()) {
      all_[step] = spread_weights(static_cast<double>(step) / static_cast<double>(kStepsPerPixel));
    }
    return all_[step];
  }

 private:
  std::vector<std::vector<float>> all_;
};

}  // namespace

FocusedLens::FocusedLens(double focal_length, double f_number, double pitch, double focus)
    : scale_(focal_length * focal_length / (f_number * (focus - focal_length)) / 4 / pitch), focus_(focus) {}

double FocusedLens::sigma_px(double depth) const { return scale_ * std::abs(depth - focus_) / depth; }

std::vector<float> spread_weights(double sigma) {
  if (sigma < kSampled) {
    const auto side = static_cast<float>(sigma * sigma / 2);
    return {side, 1 - 2 * side, side};
  }
  const std::vector<double> kernel = gaussian_kernel(sigma);
  return {kernel.begin(), kernel.end()};
}

void spread(int rows, int columns, std::span<const float> sigma, std::span<float> pixels) {
  Weights weights;
  std::vector<float> half(pixels.size(), 0.0F);
  const auto pass = [&](std::span<const float> from, std::span<float> to, bool down) {
    std::fill(to.begin(), to.end(), 0.0F);
    const int last = (down ? rows : columns) - 1;
    const std::ptrdiff_t step = down ? columns : 1;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(r) * columns + c;
        const std::vector<float>& w = weights.of(sigma[static_cast<std::size_t>(i)]);
        const int reach = static_cast<int>(w.size() / 2);
        const int place = down ? r : c;
        for (int k = -reach; k <= reach; ++k) {
          const int at = std::clamp(place + k, 0, last);  // at the border as much comes in as leaves
          to[static_cast<std::size_t>(i + (at - place) * step)] +=
              w[static_cast<std::size_t>(k + reach)] * from[static_cast<std::size_t>(i)];
        }
      }
    }
  };
  pass(pixels, half, true);
  pass(half, pixels, false);
}

}  // namespace selfproj
