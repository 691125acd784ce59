#include "sim/scene/targets.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/scene/even_numbers.h"

namespace selfproj {

FlatPlate::FlatPlate(double height_mm, const TargetTolerance& tolerance, std::uint64_t seed) : height_(height_mm) {
  EvenNumbers random(seed);
  height_ += random.within(tolerance.height_mm);
  double sum = 0;
  for (std::size_t i = 0; i < waves_.size(); ++i) {
    constexpr double kTurn = 2 * std::numbers::pi;
    constexpr double kLongest = 800;  // mm; each wave is about half as long as the one before
    constexpr double kShrink = 0.53;
    const double length = kLongest * std::pow(kShrink, static_cast<double>(i));
    const double direction = kTurn * random.next();
    const double amplitude = 1 - 0.5 * random.next();
    waves_[i] = {amplitude, kTurn / length * std::cos(direction), kTurn / length * std::sin(direction),
                 kTurn * random.next()};
    sum += amplitude;
  }
  for (Wave& wave : waves_) {
    wave.amplitude *= tolerance.flatness_mm / 2 / sum;
  }
}

double FlatPlate::height(double x, double y, double /*t*/) const {
  double height = height_;
  for (const Wave& w : waves_) {
    height += w.amplitude * std::cos(w.along_x * x + w.along_y * y + w.phase);
  }
  return height;
}

HeightRange FlatPlate::range(const Box& box, double t0, double /*t1*/) const {
  const double dx = (box.x1 - box.x0) / 2;
  const double dy = (box.y1 - box.y0) / 2;
  const double middle = height((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, t0);
  double reach = 0;  // the height's greatest change from the middle
  double all = 0;
  for (const Wave& w : waves_) {
    const double amplitude = std::abs(w.amplitude);
    reach += amplitude * std::min(2.0, std::abs(w.along_x) * dx + std::abs(w.along_y) * dy);
    all += amplitude;
  }
  return {std::max(middle - reach, height_ - all), std::min(middle + reach, height_ + all)};
}

Smoothness FlatPlate::smoothness(const Box& /*box*/) const {
  Smoothness bounds{0, 0, 0};
  for (const Wave& w : waves_) {
    const double k = std::hypot(w.along_x, w.along_y);
    const double amplitude = std::abs(w.amplitude);
    bounds.slope += amplitude * k;
    bounds.curvature += amplitude * k * k;
    bounds.change += amplitude * k * k * k;
  }
  return bounds;
}

StepBlock::StepBlock(std::vector<double> heights_mm, double tread_mm, double shift_mm, const TargetTolerance& tolerance,
                     std::uint64_t seed)
    : heights_(std::move(heights_mm)),
      tread_(tread_mm),
      begin_(shift_mm - tread_mm * static_cast<double>(heights_.size()) / 2) {
  EvenNumbers random(seed);
  for (double& height : heights_) {
    height += random.within(tolerance.height_mm);
  }
}

double StepBlock::height(double /*x*/, double y, double /*t*/) const {
  const double tread = std::floor((y - begin_) / tread_);
  return tread >= 0 && tread < static_cast<double>(heights_.size()) ? heights_[static_cast<std::size_t>(tread)] : 0;
}

HeightRange StepBlock::range(const Box& box, double /*t0*/, double /*t1*/) const {
  const auto count = static_cast<double>(heights_.size());
  const double first = std::clamp(std::floor((box.y0 - begin_) / tread_), -1.0, count);
  const double last = std::clamp(std::floor((box.y1 - begin_) / tread_), -1.0, count);
  HeightRange result{1e300, -1e300};
  for (double tread = first; tread <= last; ++tread) {
    const double height = tread >= 0 && tread < count ? heights_[static_cast<std::size_t>(tread)] : 0;
    result = {std::min(result.low, height), std::max(result.high, height)};
  }
  return result;
}

}  // namespace selfproj
