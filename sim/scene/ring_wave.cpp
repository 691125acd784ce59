#include "sim/scene/ring_wave.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace selfproj::sim {
namespace {

constexpr double kGravity = 9800;             // mm/s²
constexpr double kTensionByDensity = 7.29e4;  // mm³/s²: of clean water at 20 °C, 72.8 mN/m and 998 kg/m³
constexpr double kTail = 6;                   // extent of the wave beyond its front, in s

}  // namespace

RingWave::RingWave(double depth_mm, double crater_mm, double s_mm, double longest_s)
    : speed_(std::sqrt(kGravity * depth_mm)), s_(s_mm) {
  if (!(depth_mm > 0 && crater_mm > 0 && s_mm > 0 && longest_s > 0)) {
    throw std::invalid_argument("a ring wave's sizes must be greater than 0");
  }
  const double furthest = speed_ * longest_s + kTail * s_;
  radii_ = static_cast<std::size_t>(std::ceil(furthest / kStep)) + 1;
  const std::size_t times = static_cast<std::size_t>(std::ceil(longest_s / kTimeStep)) + 2;

  // Trapezoids over k, up to where the exponential has vanished. Their step must resolve radii and travelled distances.
  const double last = kTail / s_;
  const double step = 1 / (furthest + speed_ * longest_s);
  const auto count = static_cast<std::size_t>(std::ceil(last / step));
  std::vector<float> bessel(radii_ * count);  // multiplied by the weights
  for (std::size_t i = 0; i < count; ++i) {
    const double k = static_cast<double>(i + 1) * step;
    const double weight = -crater_mm * std::pow(s_, 4) / 2 * std::pow(k, 3) * std::exp(-k * k * s_ * s_ / 2) * step;
    for (std::size_t r = 0; r < radii_; ++r) {
      bessel[i * radii_ + r] = static_cast<float>(weight * ::j0(k * kStep * static_cast<double>(r)));
    }
  }
  rise_.assign(times * radii_, 0.0F);
  for (std::size_t t = 0; t < times; ++t) {
    float* to = rise_.data() + t * radii_;
    for (std::size_t i = 0; i < count; ++i) {
      const double k = static_cast<double>(i + 1) * step;
      const auto phase = static_cast<float>(std::cos(omega(k, depth_mm) * kTimeStep * static_cast<double>(t)));
      const float* from = bessel.data() + i * radii_;
      for (std::size_t r = 0; r < radii_; ++r) {
        to[r] += phase * from[r];
      }
    }
  }
  for (const float rise : rise_) {
    most_ = std::max(most_, std::abs(static_cast<double>(rise)));
  }
}

double RingWave::omega(double k, double depth_mm) {
  return std::sqrt((kGravity * k + kTensionByDensity * k * k * k) * std::tanh(k * depth_mm));
}

RingWave::Profile RingWave::profile(double t) const {
  Profile profile;
  if (t < 0) {
    return profile;
  }
  const std::size_t times = rise_.size() / radii_;
  const double place = std::min(t / kTimeStep, static_cast<double>(times - 2));
  const auto row = static_cast<std::size_t>(place);
  const double f = place - static_cast<double>(row);
  const float* now = rise_.data() + row * radii_;
  const float* next = now + radii_;
  const double reach = speed_ * t + kTail * s_;
  const std::size_t count = std::min(radii_, static_cast<std::size_t>(std::ceil(reach / kStep)) + 1);
  profile.values_.resize(count);
  for (std::size_t r = 0; r < count; ++r) {
    const auto a = static_cast<double>(now[r]);
    profile.values_[r].rise = a + f * (static_cast<double>(next[r]) - a);
  }
  for (std::size_t r = 1; r + 1 < count; ++r) {
    profile.values_[r].slope = (profile.values_[r + 1].rise - profile.values_[r - 1].rise) / (2 * kStep);
  }
  return profile;
}

}  // namespace selfproj::sim
