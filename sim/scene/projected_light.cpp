#include "sim/scene/projected_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "host/io/float_image.h"

namespace selfproj {
namespace {

constexpr double kReach = 4;  // reach of the blur, in standard deviations

// The blurred pattern with `margin` dark pixels around it.
FloatImage blurred(const FloatImage& pattern, int margin, double sigma) {
  FloatImage image(pattern.rows + 2 * margin, pattern.columns + 2 * margin);
  for (int r = 0; r < pattern.rows; ++r) {
    std::copy_n(pattern.row(r), pattern.columns, image.row(r + margin) + margin);
  }
  if (sigma <= 0) {
    return image;
  }
  const std::vector<double> kernel = gaussian_kernel(sigma);
  const int reach = static_cast<int>(kernel.size() / 2);
  FloatImage half(image.rows, image.columns);  // blurred across lines
  for (int r = 0; r < image.rows; ++r) {
    const float* from = image.row(r);
    if (std::all_of(from, from + image.columns, [](float value) { return value == 0; })) {
      continue;
    }
    for (int k = -reach; k <= reach; ++k) {
      if (r + k < 0 || r + k >= image.rows) {
        continue;
      }
      const auto weight = static_cast<float>(kernel[static_cast<std::size_t>(k + reach)]);
      float* to = half.row(r + k);
      for (int c = 0; c < image.columns; ++c) {
        to[c] += weight * from[c];
      }
    }
  }
  std::fill(image.values.begin(), image.values.end(), 0.0F);
  for (int r = 0; r < image.rows; ++r) {
    const float* from = half.row(r);
    if (std::all_of(from, from + image.columns, [](float value) { return value == 0; })) {
      continue;
    }
    float* to = image.row(r);
    for (int k = -reach; k <= reach; ++k) {
      const auto weight = static_cast<float>(kernel[static_cast<std::size_t>(k + reach)]);
      const int first = std::max(0, k);
      const int last = std::min(image.columns, image.columns + k);
      for (int c = first; c < last; ++c) {
        to[c] += weight * from[c - k];
      }
    }
  }
  return image;
}

std::vector<double> centres_of(const FloatImage& pattern) {
  const auto columns = static_cast<std::size_t>(pattern.columns);
  std::vector<double> m0(columns);
  std::vector<double> m1(columns);
  for (int r = 0; r < pattern.rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      m0[c] += static_cast<double>(pattern.row(r)[c]);
      m1[c] += static_cast<double>(pattern.row(r)[c]) * r;
    }
  }
  for (std::size_t c = 0; c < columns; ++c) {
    m1[c] = m0[c] > 0 ? m1[c] / m0[c] : std::numeric_limits<double>::quiet_NaN();
  }
  return m1;
}

}  // namespace

std::vector<double> gaussian_kernel(double sigma) {
  const int reach = static_cast<int>(std::ceil(kReach * sigma));
  std::vector<double> kernel(static_cast<std::size_t>(2 * reach + 1));
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double weight = sigma > 0 ? std::exp(-0.5 * k * k / (sigma * sigma)) : 1;
    kernel[static_cast<std::size_t>(k + reach)] = weight;
    sum += weight;
  }
  for (double& weight : kernel) {
    weight /= sum;
  }
  return kernel;
}

ProjectedLight::ProjectedLight(const FloatImage& pattern, double blur)
    : margin_(static_cast<int>(std::ceil(kReach * blur)) + 1),
      light_(blurred(pattern, margin_, blur)),
      ranges_(light_),
      centres_(centres_of(pattern)) {}

double ProjectedLight::at(PixelPoint p) const {
  const double r = p.row + margin_;
  const double c = p.column + margin_;
  if (!(r > 0 && c > 0 && r < light_.rows - 1 && c < light_.columns - 1)) {
    return 0;
  }
  const int r0 = static_cast<int>(r);
  const int c0 = static_cast<int>(c);
  const double fr = r - r0;
  const double fc = c - c0;
  const float* above = light_.row(r0) + c0;
  const float* below = above + light_.columns;
  return (1 - fr) * ((1 - fc) * static_cast<double>(above[0]) + fc * static_cast<double>(above[1])) +
         fr * ((1 - fc) * static_cast<double>(below[0]) + fc * static_cast<double>(below[1]));
}

MinMaxPyramid::Range ProjectedLight::range(double line_0, double line_1, double column_0, double column_1) const {
  const double last_row = light_.rows - 1.0;
  const double last_column = light_.columns - 1.0;
  const double r0 = std::max(0.0, std::floor(line_0 + margin_));
  const double r1 = std::min(last_row, std::ceil(line_1 + margin_));
  const double c0 = std::max(0.0, std::floor(column_0 + margin_));
  const double c1 = std::min(last_column, std::ceil(column_1 + margin_));
  if (r0 > r1 || c0 > c1) {
    return {0, 0};
  }
  MinMaxPyramid::Range found =
      ranges_.range(static_cast<int>(r0), static_cast<int>(r1), static_cast<int>(c0), static_cast<int>(c1));
  if (line_0 + margin_ < 0 || line_1 + margin_ > last_row || column_0 + margin_ < 0 ||
      column_1 + margin_ > last_column) {
    found.low = std::min(found.low, 0.0F);  // outside the pattern
  }
  return found;
}

bool ProjectedLight::is_dark(double line_0, double line_1, double column_0, double column_1) const {
  return range(line_0, line_1, column_0, column_1).high <= 0;
}

double ProjectedLight::line_centre(double column) const {
  const auto last = static_cast<double>(centres_.size() - 1);
  if (!(column >= 0 && column <= last)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto c0 = static_cast<std::size_t>(column);
  const std::size_t c1 = std::min(c0 + 1, centres_.size() - 1);
  const double f = column - static_cast<double>(c0);
  return f == 0 ? centres_[c0] : (1 - f) * centres_[c0] + f * centres_[c1];
}

}  // namespace selfproj
