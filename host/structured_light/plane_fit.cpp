#include "host/structured_light/plane_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "host/files/numbers.h"
#include "selfproj/images/float_image.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {
namespace {

struct Sample {
  cv::Vec3d at;
  double rounding;  // standard deviation that rounding to codes alone gives its z
  bool on = true;   // the plane
};

using Plane = cv::Vec3d;  // z0, a, b

double residual(const Plane& plane, const Sample& sample) {
  return sample.at[2] - plane[0] - plane[1] * sample.at[0] - plane[2] * sample.at[1];
}

std::vector<Sample> samples_of(const Triangulation& triangulation, const images::FloatImage& depth,
                               const PlaneRegion& region) {
  std::vector<Sample> samples;
  for (int row = region.row; row < region.row + region.rows; ++row) {
    for (int column = region.column; column < region.column + region.columns; ++column) {
      const auto i =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(depth.columns) + static_cast<std::size_t>(column);
      if (!std::isnan(depth.values[i])) {
        const Point3f at = triangulation.point(i, depth.values[i]);
        samples.push_back({{static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)},
                           triangulation.rounding_error(i, depth.values[i])});
      }
    }
  }
  return samples;
}

// Least squares over the samples that are on; nothing if they are fewer than 3 or lie on a line.
std::optional<Plane> least_squares(const std::vector<Sample>& samples) {
  double count = 0;
  cv::Vec3d mean;
  for (const Sample& sample : samples) {
    if (sample.on) {
      ++count;
      mean += sample.at;
    }
  }
  if (count < 3) {
    return std::nullopt;
  }
  mean /= count;
  // Relative to the mean, so that the normal equations of a, b are well scaled and z0 separates.
  cv::Matx22d square;
  cv::Vec2d with_z;
  for (const Sample& sample : samples) {
    if (sample.on) {
      const cv::Vec3d offset = sample.at - mean;
      const cv::Vec2d across(offset[0], offset[1]);
      square += across * across.t();
      with_z += across * offset[2];
    }
  }
  constexpr double kOnALine = 1e-12;  // of the sum of both extents squared, squared
  if (!(cv::determinant(square) > kOnALine * cv::trace(square) * cv::trace(square))) {
    return std::nullopt;
  }
  const cv::Vec2d slope = square.inv(cv::DECOMP_CHOLESKY) * with_z;
  return Plane(mean[2] - slope.dot({mean[0], mean[1]}), slope[0], slope[1]);
}

constexpr double kRoundings = 4;  // within so many standard deviations a sample is on the plane

// The plane through three samples on which most of some samples lie; least squares over all where no triple makes one.
std::optional<Plane> likeliest_plane(const std::vector<Sample>& samples) {
  constexpr std::size_t kLooked = 2000;
  constexpr int kTriples = 400;
  std::vector<Sample> some;
  for (std::size_t i = 0; i < samples.size(); i += std::max<std::size_t>(1, samples.size() / kLooked)) {
    some.push_back(samples[i]);
  }
  std::mt19937_64 random(1);
  std::optional<Plane> best = least_squares(samples);
  std::ptrdiff_t most = -1;
  for (int k = 0; best && k < kTriples; ++k) {
    const std::optional<Plane> plane =
        k == 0
            ? best
            : least_squares({some[random() % some.size()], some[random() % some.size()], some[random() % some.size()]});
    if (!plane) {
      continue;
    }
    const auto on = std::count_if(some.begin(), some.end(), [&](const Sample& sample) {
      return std::abs(residual(*plane, sample)) <= kRoundings * sample.rounding;
    });
    if (on > most) {
      most = on;
      best = plane;
    }
  }
  return best;
}

// Marks the samples on the plane. Returns whether that has changed anything.
bool mark(const Plane& plane, double spread, std::vector<Sample>& samples) {
  constexpr double kSpreads = 4.5;
  bool changed = false;
  for (Sample& sample : samples) {
    const bool on = std::abs(residual(plane, sample)) <= std::max(kRoundings * sample.rounding, kSpreads * spread);
    changed = changed || on != sample.on;
    sample.on = on;
  }
  return changed;
}

// The standard deviation of the residuals of the samples that are on, by their median.
double spread_of(const Plane& plane, const std::vector<Sample>& samples) {
  constexpr double kPerMedian = 1.4826;
  std::vector<double> sizes;
  for (const Sample& sample : samples) {
    if (sample.on) {
      sizes.push_back(std::abs(residual(plane, sample)));
    }
  }
  return kPerMedian * files::median_of(std::move(sizes));
}

}  // namespace

PlaneFit fit_plane(const Triangulation& triangulation, const images::FloatImage& depth) {
  return fit_plane(triangulation, depth, {0, 0, depth.rows, depth.columns});
}

PlaneFit fit_plane(const Triangulation& triangulation, const images::FloatImage& depth, const PlaneRegion& region) {
  if (depth.rows != triangulation.rows() || depth.columns != triangulation.columns()) {
    throw std::invalid_argument("plane fit: the depth image has another size than the triangulation");
  }
  if (region.row < 0 || region.column < 0 || region.rows < 0 || region.columns < 0 ||
      region.rows > depth.rows - region.row || region.columns > depth.columns - region.column) {
    throw std::invalid_argument("plane fit: the region is not within the image");
  }
  constexpr int kMaxRounds = 30;
  std::vector<Sample> samples = samples_of(triangulation, depth, region);
  PlaneFit fit;
  fit.points = samples.size();
  std::optional<Plane> plane = likeliest_plane(samples);
  if (!plane) {
    return fit;
  }
  mark(*plane, 0, samples);
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::optional<Plane> next = least_squares(samples);
    if (!next) {
      break;
    }
    plane = next;
    if (!mark(*plane, spread_of(*plane, samples), samples)) {
      break;
    }
  }
  double squares = 0;
  double rounding = 0;
  double count = 0;
  fit.greatest = 0;
  for (const Sample& sample : samples) {
    if (sample.on) {
      const double off = residual(*plane, sample);
      ++count;
      squares += off * off;
      fit.greatest = std::max(fit.greatest, std::abs(off));
      rounding += sample.rounding * sample.rounding;
    }
  }
  fit.points = static_cast<std::size_t>(count);
  fit.left_out = samples.size() - fit.points;
  fit.z0 = (*plane)[0];
  fit.a = (*plane)[1];
  fit.b = (*plane)[2];
  fit.rms = std::sqrt(squares / count);
  fit.rounding_rms = std::sqrt(rounding / count);
  return fit;
}

}  // namespace selfproj::structured_light
