#include "host/light_section/height_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "host/files/user_error.h"

namespace selfproj {
namespace {

constexpr double kClose = 0.5;  // mm: how near to its tread a sample must be

bool place(const RigOptics& optics, HeightSample& sample) {
  const std::optional<cv::Vec2d> ray = optics.ray({sample.row, static_cast<double>(sample.column)});
  const LightSheet sheet{sample.line, 0, 0.5 * (optics.rig().projector.columns - 1)};
  const std::optional<double> z = ray ? optics.meet(*ray, sheet) : std::nullopt;
  if (z) {
    sample.x = *z * (*ray)[0];
    sample.y = *z * (*ray)[1];
    sample.z = *z;
  }
  return z.has_value();
}

// How the true height follows from that by the geometry, roughly: p . (1, x, y, height).
using Rough = cv::Vec4d;

double rough_height(const Rough& p, const Rig& rig, const HeightSample& sample) {
  return p.dot({1, sample.x, sample.y, rig.plane_z_mm - sample.z});
}

// The tread nearest to a height; none if all are further than `close`.
std::optional<std::size_t> tread_of(const std::vector<double>& steps, double height, double close) {
  const auto nearest = std::min_element(
      steps.begin(), steps.end(), [height](double a, double b) { return std::abs(a - height) < std::abs(b - height); });
  return std::abs(*nearest - height) < close ? std::optional(static_cast<std::size_t>(nearest - steps.begin()))
                                             : std::nullopt;
}

// The shift of all heights, and the lean across the belt, with which most samples lie near treads, and most treads have
// samples.
Rough shifted(const Rig& rig, const std::vector<HeightSample>& samples, const std::vector<double>& steps,
              double close) {
  constexpr int kOffsets = 60;  // to either side, of 0.5 mm
  constexpr int kLeans = 8;     // to either side, of 0.004
  Rough best;
  double most = -1;
  for (int k = -kLeans; k <= kLeans; ++k) {
    for (int i = -kOffsets; i <= kOffsets; ++i) {
      const Rough shift(0.5 * i, 0, 0.004 * k, 1);
      std::vector<double> on(steps.size(), 0);
      for (const HeightSample& sample : samples) {
        const double height = rough_height(shift, rig, sample);
        if (const auto tread = tread_of(steps, height, close)) {
          on[*tread] += 1 - std::abs(steps[*tread] - height) / close;
        }
      }
      double sum = 0;
      for (const double count : on) {
        sum += count + (count > 0 ? 0.02 * static_cast<double>(samples.size()) : 0);
      }
      if (sum > most) {
        most = sum;
        best = shift;
      }
    }
  }
  return best;
}

// From there by least squares over the samples near treads, which become more and the treads narrower.
Rough rough_heights(const Rig& rig, const std::vector<HeightSample>& samples, const std::vector<double>& steps) {
  constexpr std::size_t kLooked = 2000;
  constexpr int kRounds = 8;
  double close = 10;
  for (std::size_t k = 1; k < steps.size(); ++k) {
    close = std::min(close, 0.3 * (steps[k] - steps[k - 1]));
  }
  std::vector<HeightSample> some;
  for (std::size_t i = 0; i < samples.size(); i += std::max<std::size_t>(1, samples.size() / kLooked)) {
    some.push_back(samples[i]);
  }
  Rough rough = shifted(rig, some, steps, close);
  for (int round = 0; round < kRounds; ++round) {
    cv::Matx44d matrix = cv::Matx44d::zeros();
    cv::Vec4d right(0, 0, 0, 0);
    for (const HeightSample& sample : some) {
      if (const auto tread = tread_of(steps, rough_height(rough, rig, sample), close)) {
        const cv::Vec4d terms(1, sample.x, sample.y, rig.plane_z_mm - sample.z);
        matrix += terms * terms.t();
        right += steps[*tread] * terms;
      }
    }
    rough = matrix.inv(cv::DECOMP_SVD) * right;
    close = std::max(std::min(kClose, close), 0.7 * close);
  }
  return rough;
}

// Gives each sample its tread, and leaves out those without one or near a step.
std::vector<HeightSample> on_treads(const Rig& rig, std::vector<HeightSample> samples,
                                    const std::vector<double>& steps) {
  constexpr int kApart = 3;
  const Rough rough = rough_heights(rig, samples, steps);
  const std::size_t none = steps.size();
  for (HeightSample& sample : samples) {
    sample.level = tread_of(steps, rough_height(rough, rig, sample), kClose).value_or(none);
  }
  std::vector<HeightSample> kept;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    // The samples of an image lie side by side, in the order of their columns.
    bool good = samples[i].level != none;
    for (const int step : {-1, 1}) {
      for (std::size_t k = i; good;) {
        if ((step < 0 && k == 0) || (step > 0 && k + 1 == samples.size())) {
          break;
        }
        k = step < 0 ? k - 1 : k + 1;
        const bool beside = samples[k].line == samples[i].line && samples[k].position == samples[i].position &&
                            std::abs(samples[k].column - samples[i].column) <= kApart;
        if (!beside) {
          break;
        }
        good = samples[k].level == samples[i].level;
      }
    }
    if (good) {
      kept.push_back(samples[i]);
      kept.back().height_mm = steps[samples[i].level];
    }
  }
  return kept;
}

}  // namespace

std::vector<HeightSample> height_samples(const Rig& rig, const std::vector<HeightPosition>& positions,
                                         const HeightSettings& settings) {
  const RigOptics optics(rig);
  std::vector<HeightSample> samples;
  for (std::size_t p = 0; p < positions.size(); ++p) {
    for (const LineSighting& seen : positions[p].seen) {
      HeightSample sample{seen.row, seen.column, seen.line, p, p, positions[p].height_mm};
      if (place(optics, sample)) {
        samples.push_back(sample);
      }
    }
  }
  return settings.steps_mm.empty() ? samples : on_treads(rig, std::move(samples), settings.steps_mm);
}

void place_samples(const RigOptics& optics, std::vector<HeightSample>& samples) {
  samples.erase(
      std::remove_if(samples.begin(), samples.end(), [&](HeightSample& sample) { return !place(optics, sample); }),
      samples.end());
}

}  // namespace selfproj
