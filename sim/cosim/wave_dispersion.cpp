#include "sim/cosim/wave_dispersion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

namespace selfproj::sim {
namespace {

constexpr double kUnobserved = std::numeric_limits<double>::quiet_NaN();
constexpr double kCellsAWave = 10;  // in the length of the shortest wave

// Returns the number of cells along a side. It is even, because cv::dct needs that.
int cells_along(double length, double shortest) {
  return 2 * std::max(1, static_cast<int>(std::ceil(length * kCellsAWave / shortest / 2)));
}

constexpr double kUnknowns = 4;  // of a standing wave: mean, two amplitudes, frequency

// Returns the sum of squares of y that remains after a fit of an oscillation at this angular frequency. The mean of y
// must be 0. The fit consists of a cosine and a sine, each without its mean.
double rest_at(const std::vector<double>& t, const std::vector<double>& y, double omega) {
  const auto n = static_cast<double>(t.size());
  double c1 = 0, s1 = 0, cc = 0, cs = 0, ss = 0, cy = 0, sy = 0, yy = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double c = std::cos(omega * t[i]);
    const double s = std::sin(omega * t[i]);
    c1 += c;
    s1 += s;
    cc += c * c;
    cs += c * s;
    ss += s * s;
    cy += c * y[i];
    sy += s * y[i];
    yy += y[i] * y[i];
  }
  cc -= c1 * c1 / n;
  cs -= c1 * s1 / n;
  ss -= s1 * s1 / n;
  const double determinant = cc * ss - cs * cs;
  const double explained = (ss * cy * cy - 2 * cs * cy * sy + cc * sy * sy) / determinant;
  return determinant > 0 ? std::max(0.0, yy - explained) : yy;
}

// The values of an unknown that are tried, in equal steps of its logarithm.
class Grid {
 public:
  Grid(double low, double high, std::size_t steps)
      : low_(low), step_(std::log(high / low) / static_cast<double>(steps)), count_(steps + 1) {}
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] double at(double i) const { return low_ * std::exp(step_ * i); }

  // Returns where a curve over these values has its minimum, interpolated by a parabola. NaN if the least value is the
  // first or the last one.
  [[nodiscard]] double least_of(const std::vector<double>& curve) const {
    const auto best = static_cast<std::size_t>(std::min_element(curve.begin(), curve.end()) - curve.begin());
    if (best == 0 || best + 1 == count_) {
      return kUnobserved;
    }
    const double bend = curve[best - 1] - 2 * curve[best] + curve[best + 1];
    return at(static_cast<double>(best) + (bend > 0 ? 0.5 * (curve[best - 1] - curve[best + 1]) / bend : 0));
  }

  // Returns half the width of the range around the minimum in which a curve is less than its minimum plus `more`. The
  // range ends where the grid ends.
  [[nodiscard]] double half_width(const std::vector<double>& curve, double more) const {
    const auto best = static_cast<std::size_t>(std::min_element(curve.begin(), curve.end()) - curve.begin());
    const double level = curve[best] + more;
    std::size_t from = best;
    while (from > 0 && curve[from - 1] < level) {
      --from;
    }
    std::size_t to = best;
    while (to + 1 < count_ && curve[to + 1] < level) {
      ++to;
    }
    const auto crossing = [&](std::size_t inside, std::size_t outside, double towards) {
      const double share = (level - curve[inside]) / (curve[outside] - curve[inside]);
      return at(static_cast<double>(inside) + towards * share);
    };
    const double low = from == 0 ? at(0) : crossing(from, from - 1, -1);
    const double high = to + 1 == count_ ? at(static_cast<double>(to)) : crossing(to, to + 1, 1);
    return (high - low) / 2;
  }

 private:
  double low_, step_;
  std::size_t count_;
};

// The phase speeds that are tried, mm/s. They include that of any wave on water in a laboratory.
const Grid& speeds() {
  static const Grid grid(100, 1500, 300);
  return grid;
}

// Where the sum of curves has its minimum, and the standard deviation of this place. A curve may have several rows over
// the same values. At each value, the least of the rows of the sum counts. The standard deviation is the greater one of
// two: that of a jackknife, which leaves out every `groups`-th curve, and half the width of the range in which the sum
// exceeds its minimum by less than 1, the variance of the noise.
struct Best {
  double value, deviation;
};
Best best_of(const Grid& grid, const std::vector<std::vector<double>>& curves, std::size_t groups) {
  const auto sum_without = [&](std::size_t group) {
    std::vector<double> sum(curves.at(0).size(), 0.0);
    for (std::size_t c = 0; c < curves.size(); ++c) {
      const bool left_out = group < groups && c % groups == group;
      for (std::size_t i = 0; i < sum.size() && !left_out; ++i) {
        sum[i] += curves[c][i];
      }
    }
    for (std::size_t i = grid.count(); i < sum.size(); ++i) {
      sum[i % grid.count()] = std::min(sum[i % grid.count()], sum[i]);
    }
    sum.resize(grid.count());
    return sum;
  };
  std::vector<double> values;
  double mean = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    values.push_back(grid.least_of(sum_without(group)));
    mean += values.back() / static_cast<double>(groups);
  }
  double squares = 0;
  for (const double value : values) {
    squares += (value - mean) * (value - mean);
  }
  const auto n = static_cast<double>(groups);
  const std::vector<double> all = sum_without(groups);
  return {grid.least_of(all), std::max(std::sqrt((n - 1) / n * squares), grid.half_width(all, 1))};
}

double omega_of(double k, double depth, double factor) {
  return std::sqrt(factor * (kStandardGravity * k + kWaterTension * k * k * k) * std::tanh(k * depth));
}

// The factors of omega^2 that are tried.
std::vector<double> factors() {
  constexpr int kFactorsAbove = 16;
  constexpr double kFactorStep = 5e-4;
  std::vector<double> all;
  for (int i = -kFactorsAbove; i <= kFactorsAbove; ++i) {
    all.push_back(1 + i * kFactorStep);
  }
  return all;
}

}  // namespace

BasinWaves::BasinWaves(const Basin& basin, double shortest, std::size_t images) : basin_(basin), images_(images) {
  const double dx = basin.x1 - basin.x0;
  const double dy = basin.y1 - basin.y0;
  if (!(dx > 0 && dy > 0 && shortest > 0 && images > 0)) {
    throw std::invalid_argument("waves in a basin: its sides, the shortest wave and the images must be more than 0");
  }
  down_ = cells_along(dx, shortest);
  across_ = cells_along(dy, shortest);
  sums_.assign(static_cast<std::size_t>(down_) * static_cast<std::size_t>(across_), 0.0);
  pixels_ = sums_;
  const double most = 2 * std::numbers::pi / shortest;
  for (int m = 0; m * std::numbers::pi / dx <= most; ++m) {
    for (int n = 0; std::hypot(m / dx, n / dy) * std::numbers::pi <= most; ++n) {
      if (m + n > 0) {
        waves_.push_back({m, n, std::hypot(m / dx, n / dy) * std::numbers::pi, {}});
      }
    }
  }
  std::sort(waves_.begin(), waves_.end(), [](const StandingWave& a, const StandingWave& b) { return a.k < b.k; });
}

void BasinWaves::add(double t, const structured_light::Triangulation& triangulation, const images::FloatImage& depth,
                     const images::FloatImage& background, double most) {
  const double down = down_ / (basin_.x1 - basin_.x0);
  const double across = across_ / (basin_.y1 - basin_.y0);
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    const float rise = background.values[i] - depth.values[i];
    if (!(std::abs(static_cast<double>(rise)) <= most)) {
      continue;
    }
    const structured_light::Point3f p = triangulation.point(i, depth.values[i]);
    const double row = (static_cast<double>(p.x) - basin_.x0) * down;
    const double column = (static_cast<double>(p.y) - basin_.y0) * across;
    if (row >= 0 && row < down_ && column >= 0 && column < across_) {
      const std::size_t cell =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(across_) + static_cast<std::size_t>(column);
      sums_[cell] += static_cast<double>(rise);
      pixels_[cell] += 1;
    }
  }
  time_sum_ += t;
  if (++taken_ == images_) {
    transform();
  }
}

void BasinWaves::transform() {
  cv::Mat heights(down_, across_, CV_64F);
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    heights.ptr<double>()[i] = pixels_[i] > 0 ? sums_[i] / pixels_[i] : 0;  // without a pixel: at rest
  }
  cv::Mat transformed;
  cv::dct(heights, transformed);
  const double scale = 1 / std::sqrt(static_cast<double>(down_) * across_);
  for (StandingWave& wave : waves_) {
    const double factor = (wave.m > 0 ? std::numbers::sqrt2 : 1) * (wave.n > 0 ? std::numbers::sqrt2 : 1);
    wave.amplitude.push_back(scale * factor * transformed.at<double>(wave.m, wave.n));
  }
  times_.push_back(time_sum_ / static_cast<double>(images_));
  std::fill(sums_.begin(), sums_.end(), 0.0);
  std::fill(pixels_.begin(), pixels_.end(), 0.0);
  taken_ = 0;
  time_sum_ = 0;
}

WaveDispersion::WaveDispersion(const BasinWaves& measured) : times_(measured.times()) {
  constexpr double kShare = 0.75;
  const auto times = static_cast<double>(times_.size());
  const double begin = times_.empty() ? 0 : times_.front();
  for (double& t : times_) {
    t -= begin;
  }
  for (const StandingWave& wave : measured.waves()) {
    if (times < 2 * kUnknowns) {
      break;
    }
    ObservedWave h{wave, 0, 0, {}};
    std::vector<double>& y = h.wave.amplitude;
    const double mean = std::accumulate(y.begin(), y.end(), 0.0) / times;
    double all = 0;
    for (double& a : y) {
      a -= mean;
      all += a * a;
    }
    for (std::size_t i = 0; i < speeds().count(); ++i) {
      h.rest.push_back(rest_at(times_, y, wave.k * speeds().at(static_cast<double>(i))));
    }
    const double speed = speeds().least_of(h.rest);
    const double rest = std::isnan(speed) ? all : rest_at(times_, y, speed * wave.k);
    if (rest < (1 - kShare) * all) {
      h.noise = rest / (times - kUnknowns);
      h.energy = all - rest;
      observed_.push_back(std::move(h));
    }
  }
  if (observed_.empty()) {
    return;
  }
  std::vector<double> noises;
  std::transform(observed_.begin(), observed_.end(), std::back_inserter(noises),
                 [](const ObservedWave& h) { return h.noise; });
  const auto middle = noises.begin() + static_cast<std::ptrdiff_t>(noises.size() / 2);
  std::nth_element(noises.begin(), middle, noises.end());
  for (ObservedWave& h : observed_) {
    h.noise = std::max(h.noise, *middle);
    h.energy /= h.noise;
    std::transform(h.rest.begin(), h.rest.end(), h.rest.begin(), [&](double value) { return value / h.noise; });
  }
}

WaveSpeed WaveDispersion::speed(double longest, double shortest) const {
  constexpr std::size_t kFewest = 3;
  double energy = 0;
  double ks = 0;
  std::vector<std::vector<double>> curves;
  for (const ObservedWave& h : observed_) {
    const double length = 2 * std::numbers::pi / h.wave.k;
    if (length >= shortest && length < longest) {
      energy += h.energy;
      ks += h.energy * h.wave.k;
      curves.push_back(h.rest);
    }
  }
  WaveSpeed result{curves.size(), kUnobserved, kUnobserved, kUnobserved};
  if (!curves.empty()) {
    const Best best = best_of(speeds(), curves, curves.size());
    result.length = 2 * std::numbers::pi * energy / ks;
    result.speed = best.value;
    result.deviation = curves.size() < kFewest ? kUnobserved : best.deviation;
  }
  return result;
}

LongWaves WaveDispersion::long_waves() const {
  constexpr std::size_t kGroups = 10;
  static const Grid depths(3, 300, 250);
  LongWaves result{observed_.size(), kUnobserved, kUnobserved, kUnobserved, kUnobserved};
  if (observed_.size() < kGroups) {
    return result;
  }
  std::vector<std::vector<double>> curves;
  const std::vector<double> all_factors = factors();
  const auto rest = [&](const ObservedWave& h, double depth, double factor) {
    return rest_at(times_, h.wave.amplitude, omega_of(h.wave.k, depth, factor)) / h.noise;
  };
  for (const ObservedWave& h : observed_) {
    curves.emplace_back();
    for (const double factor : all_factors) {
      for (std::size_t i = 0; i < depths.count(); ++i) {
        curves.back().push_back(rest(h, depths.at(static_cast<double>(i)), factor));
      }
    }
  }
  const Best best = best_of(depths, curves, kGroups);
  result.depth = best.value;
  result.speed = std::sqrt(kStandardGravity * best.value);
  result.deviation = result.speed * best.deviation / (2 * best.value);
  double left = std::numeric_limits<double>::infinity();
  for (const double factor : all_factors) {
    const double sum =
        std::accumulate(observed_.begin(), observed_.end(), 0.0,
                        [&](double before, const ObservedWave& h) { return before + rest(h, best.value, factor); });
    left = std::min(left, sum);
  }
  result.misfit = left / ((static_cast<double>(times_.size()) - kUnknowns) * static_cast<double>(observed_.size()));
  return result;
}

}  // namespace selfproj::sim
