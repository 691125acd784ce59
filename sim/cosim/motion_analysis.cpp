#include "sim/cosim/motion_analysis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>
#include <vector>

namespace selfproj::sim {
namespace {

constexpr double kNotFound = std::numeric_limits<double>::quiet_NaN();

struct Points {
  std::vector<double> t, y;
};

Points without_nan(const std::vector<double>& t, const std::vector<double>& y) {
  Points points;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (std::isfinite(y[i])) {
      points.t.push_back(t[i]);
      points.y.push_back(y[i]);
    }
  }
  return points;
}

// By least squares; times count from `middle`, so that a part of a period can be told from a constant.
SineFit fit_at(const Points& points, double middle, double frequency) {
  cv::Matx33d normal = cv::Matx33d::zeros();
  cv::Vec3d right(0, 0, 0);
  double squares = 0;
  const double mean = std::accumulate(points.y.begin(), points.y.end(), 0.0) / static_cast<double>(points.y.size());
  for (std::size_t i = 0; i < points.t.size(); ++i) {
    const double phase = 2 * std::numbers::pi * frequency * (points.t[i] - middle);
    const cv::Vec3d row(1, std::sin(phase), std::cos(phase));
    const double y = points.y[i] - mean;
    normal += row * row.t();
    right += row * y;
    squares += y * y;
  }
  const cv::Vec3d solution = normal.inv() * right;
  const double rest = std::max(0.0, squares - solution.dot(right));
  return {frequency, mean + solution[0], std::hypot(solution[1], solution[2]),
          std::sqrt(rest / static_cast<double>(points.t.size()))};
}

// The values with a time and without NaN; those of too few are empty.
std::vector<Points> usable(const std::vector<double>& t, const std::vector<std::vector<double>>& ys) {
  constexpr std::size_t kFewest = 8;
  std::vector<Points> all;
  for (const std::vector<double>& y : ys) {
    all.push_back(without_nan(t, y));
    if (all.back().t.size() < kFewest) {
      return {};
    }
  }
  return all;
}

double middle_of(const std::vector<double>& t) {
  const auto [first, last] = std::minmax_element(t.begin(), t.end());
  return 0.5 * (*first + *last);
}

// The frequency in low..high that leaves the least.
double best_frequency(const std::vector<double>& t, const std::vector<Points>& all, double low, double high) {
  const auto [first, last] = std::minmax_element(t.begin(), t.end());
  const double middle = middle_of(t);
  const auto rest = [&](double frequency) {
    double squares = 0;
    for (const Points& points : all) {
      const double residual = fit_at(points, middle, frequency).residual;
      squares += residual * residual * static_cast<double>(points.t.size());
    }
    return squares;
  };
  constexpr double kStep = 0.05;  // of the frequency that one more period within the time is
  constexpr double kExact = 1e-6;
  const double step = std::min(kStep / std::max(*last - *first, kExact), (high - low) / 4);
  double best = low;
  double least = rest(low);
  for (double f = low + step; f < high + step; f += step) {
    const double here = rest(std::min(f, high));
    if (here < least) {
      least = here;
      best = std::min(f, high);
    }
  }
  double a = std::max(low, best - step);
  double b = std::min(high, best + step);
  while (b - a > kExact * best) {  // thirds; between neighbours of the best point there is one minimum
    const double c = a + (b - a) / 3;
    const double d = b - (b - a) / 3;
    if (rest(c) < rest(d)) {
      b = d;
    } else {
      a = c;
    }
  }
  return 0.5 * (a + b);
}

}  // namespace

SineFit fit_sine(const std::vector<double>& t, const std::vector<double>& y, double low, double high) {
  const std::vector<Points> all = usable(t, {y});
  if (all.empty()) {
    return {kNotFound, kNotFound, kNotFound, kNotFound};
  }
  return fit_at(all[0], middle_of(t), best_frequency(t, all, low, high));
}

double common_frequency(const std::vector<double>& t, const std::vector<std::vector<double>>& ys, double low,
                        double high) {
  const std::vector<Points> all = usable(t, ys);
  return all.empty() ? kNotFound : best_frequency(t, all, low, high);
}

LineFit fit_line(const std::vector<double>& t, const std::vector<double>& y) {
  const Points points = without_nan(t, y);
  const auto n = static_cast<double>(points.t.size());
  double st = 0;
  double sy = 0;
  for (std::size_t i = 0; i < points.t.size(); ++i) {
    st += points.t[i];
    sy += points.y[i];
  }
  double stt = 0;
  double sty = 0;
  for (std::size_t i = 0; i < points.t.size(); ++i) {
    stt += (points.t[i] - st / n) * (points.t[i] - st / n);
    sty += (points.t[i] - st / n) * (points.y[i] - sy / n);
  }
  if (!(stt > 0)) {
    return {kNotFound, kNotFound};
  }
  const double slope = sty / stt;
  return {sy / n - slope * st / n, slope};
}

double slope_between_jumps(const std::vector<double>& t, const std::vector<double>& y, double least, double most) {
  const Points points = without_nan(t, y);
  std::vector<double> slopes;
  for (std::size_t i = 0; i < points.t.size(); ++i) {
    for (std::size_t j = i + 1; j < points.t.size() && points.t[j] - points.t[i] <= most; ++j) {
      if (points.t[j] - points.t[i] >= least) {
        slopes.push_back((points.y[j] - points.y[i]) / (points.t[j] - points.t[i]));
      }
    }
  }
  if (slopes.empty()) {
    return kNotFound;
  }
  const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2);
  std::nth_element(slopes.begin(), middle, slopes.end());
  return *middle;
}

RingMeans::RingMeans(const structured_light::Triangulation& triangulation, const Place& place, double step,
                     std::size_t count)
    : triangulation_(triangulation), place_(place), step_(step), count_(count) {}

std::vector<double> RingMeans::means(const images::FloatImage& depth, const images::FloatImage& background,
                                     double most) const {
  constexpr std::size_t kFewest = 20;
  std::vector<double> sums(count_, 0.0);
  std::vector<std::size_t> pixels(count_, 0);
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    const float rise = background.values[i] - depth.values[i];
    if (!(std::abs(static_cast<double>(rise)) <= most)) {
      continue;
    }
    const structured_light::Point3f p = triangulation_.point(i, background.values[i]);
    const auto x = static_cast<double>(p.x);
    const auto y = static_cast<double>(p.y);
    if (x < place_.x0 || x > place_.x1 || y < place_.y0 || y > place_.y1) {
      continue;
    }
    const auto ring = static_cast<std::size_t>(std::hypot(x - place_.x, y - place_.y) / step_);
    if (ring < count_) {
      sums[ring] += static_cast<double>(rise);
      ++pixels[ring];
    }
  }
  for (std::size_t ring = 0; ring < count_; ++ring) {
    sums[ring] = pixels[ring] < kFewest ? kNotFound : sums[ring] / static_cast<double>(pixels[ring]);
  }
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<double> before = sums;
    for (std::size_t ring = 1; ring + 1 < count_; ++ring) {
      sums[ring] = (before[ring - 1] + 2 * before[ring] + before[ring + 1]) / 4;
    }
  }
  return sums;
}

double foremost_crest(const RingMeans& rings, const std::vector<double>& means, double least) {
  constexpr double kShare = 0.8;
  double greatest = least;
  for (const double mean : means) {
    greatest = mean > greatest ? mean : greatest;
  }
  for (std::size_t i = means.size() - 1; i-- > 1;) {
    const double a = means[i - 1];
    const double b = means[i];
    const double c = means[i + 1];
    if (b >= least && b >= kShare * greatest && b >= a && b > c) {
      const double bend = a - 2 * b + c;
      const double off = bend < 0 ? 0.5 * (a - c) / bend : 0;
      return rings.radius(i) + off * (rings.radius(1) - rings.radius(0));
    }
  }
  return kNotFound;
}

}  // namespace selfproj::sim
