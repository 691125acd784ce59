#include "host/light_section/height_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/files/user_error.h"
#include "host/light_section/height_model.h"
#include "host/light_section/height_samples.h"
#include "host/rig/geometry.h"
#include "host/rig/height_correction.h"
#include "host/rig/optics.h"

namespace selfproj {
namespace {

constexpr std::size_t kLeastLevels = 3;
constexpr std::size_t kLeastSamples = 200;  // of a level
constexpr int kMostFittedOrder = 6;
constexpr int kMostHeightOrder = 2;  // the rest of a geometry is hardly curved in height
constexpr int kParts = 16;           // of the columns, for unevenness

std::vector<HeightLevel> levels_of(const std::vector<HeightPosition>& positions, const HeightSettings& settings) {
  std::vector<HeightLevel> levels;
  if (settings.steps_mm.empty()) {
    for (const HeightPosition& position : positions) {
      levels.push_back({.name = position.name, .height_mm = position.height_mm});
    }
  }
  for (const double step : settings.steps_mm) {
    levels.push_back({.name = fmt::format("the tread of {} mm", step), .height_mm = step});
  }
  return levels;
}

// Errors of the samples, level by level: `error` gives that of each, NaN for one that does not count.
template <class Error>
void set_errors(const std::vector<HeightSample>& samples, int columns, const Error& error,
                std::vector<HeightLevel>& levels) {
  struct Sums {
    double n = 0, sum = 0, square = 0;
    std::array<std::pair<double, double>, kParts> parts{};
  };
  std::vector<Sums> all(levels.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double off = error(i);
    if (std::isnan(off)) {
      continue;
    }
    Sums& sums = all[samples[i].level];
    sums.n += 1;
    sums.sum += off;
    sums.square += off * off;
    auto& [count, total] = sums.parts.at(static_cast<std::size_t>(samples[i].column * kParts / columns));
    count += 1;
    total += off;
  }
  for (std::size_t k = 0; k < levels.size(); ++k) {
    HeightLevel& level = levels[k];
    const Sums& sums = all[k];
    level.samples = static_cast<std::size_t>(sums.n);
    level.mean_mm = sums.n > 0 ? sums.sum / sums.n : 0;
    level.rms_mm = sums.n > 0 ? std::sqrt(sums.square / sums.n) : 0;
    level.uneven_mm = 0;
    for (const auto& [count, total] : sums.parts) {
      level.uneven_mm = count > 20 ? std::max(level.uneven_mm, std::abs(total / count)) : level.uneven_mm;
    }
  }
}

void expect_samples(const std::vector<HeightLevel>& levels) {
  if (levels.size() < kLeastLevels) {
    throw UserError("heights",
                    fmt::format("{} are too few; {} or more are needed, 5 are good", levels.size(), kLeastLevels));
  }
  for (const HeightLevel& level : levels) {
    if (level.samples < kLeastSamples) {
      throw UserError(level.name,
                      fmt::format("the line was found in {} places only; {} are needed", level.samples, kLeastSamples));
    }
  }
}

// Heights by the geometry must rise with the true ones.
void expect_order(const std::vector<HeightLevel>& levels) {
  for (std::size_t k = 1; k < levels.size(); ++k) {
    const double true_step = levels[k].height_mm - levels[k - 1].height_mm;
    // The mean error is that of the geometry, so the step by the geometry is the true one plus the change of the error.
    const double step = true_step + levels[k].mean_mm - levels[k - 1].mean_mm;
    if (!(step > 0.5 * true_step && step < 2 * true_step)) {
      throw UserError(levels[k].name,
                      fmt::format("is given as {} mm above {}, but the rig sees it {:.3f} mm above; are the heights in "
                                  "the order of the folders?",
                                  true_step, levels[k - 1].name, step));
    }
  }
}

// a, b, c and s of z = a x + b y + c - s height, by least squares.
cv::Vec4d plane_of(const std::vector<HeightSample>& samples) {
  cv::Matx44d matrix = cv::Matx44d::zeros();
  cv::Vec4d right(0, 0, 0, 0);
  for (const HeightSample& s : samples) {
    const cv::Vec4d terms(s.x, s.y, 1, -s.height_mm);
    matrix += terms * terms.t();
    right += s.z * terms;
  }
  return matrix.inv(cv::DECOMP_SVD) * right;
}

// Heights that are all wrong by one factor fit as well as right ones. What the rig makes of them tells.
void expect_scale(const Rig& rig, double seen, const HeightSettings& settings) {
  const double allowed = settings.scale_tolerance.value_or(rig.calibration ? HeightSettings::kCalibratedScale
                                                                           : HeightSettings::kDrawnScale);
  if (!(std::abs(seen - 1) <= allowed)) {
    throw CheckFailed(
        fmt::format("heights: the rig sees {:.3f} mm for each mm of the given heights; {:g} % more or less are allowed "
                    "(--scale-tolerance): all are likely wrong by one factor, or this is not the rig that took the "
                    "images",
                    seen, 100 * allowed));
  }
}

// The rig with its belt where the plates lie, by plane_of.
Rig with_belt(const Rig& rig, const cv::Vec4d& found) {
  Rig result = rig;
  if (rig.belt_pose || !rig.calibration) {  // known better than from a strip of the plate, or not to be known at all
    result.plane_z_mm = found[2];
    return result;
  }
  const cv::Vec3d normal = cv::normalize(cv::Vec3d(-found[0], -found[1], 1));  // rows first
  const cv::Vec3d along = cv::normalize(cv::Vec3d(1, 0, 0) - normal[0] * normal);
  result.plane_z_mm = found[2] * normal[2];
  result.belt_pose = RigBeltPose{{along[1], along[0], along[2]}, {normal[1], normal[0], normal[2]}};
  return result;
}

// The heights by the geometry of the samples used, but for a thousandth at either end.
void set_range(const Rig& rig, const std::vector<HeightSample>& samples, const std::vector<char>& used,
               RigHeights& heights) {
  std::vector<double> all;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (used[i] != 0) {
      all.push_back(rig.plane_z_mm - samples[i].z);
    }
  }
  std::sort(all.begin(), all.end());
  heights.lowest_mm = all[all.size() / 1000];
  heights.highest_mm = all[all.size() - 1 - all.size() / 1000];
}

// Leaves out of the samples used those whose error is far beyond the rest.
std::vector<char> without_outliers(const std::vector<HeightSample>& samples, const std::vector<char>& used,
                                   const Rig& rig, const RigHeights& heights) {
  constexpr double kFar = 6;
  const HeightCorrection correction(rig.camera, heights);
  std::vector<double> off(samples.size(), kUnknown);
  std::vector<double> sorted;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const HeightSample& s = samples[i];
    if (used[i] != 0) {
      const double geometric = rig.plane_z_mm - s.z;
      off[i] = std::abs(geometric + correction.at(s.row, s.column, geometric) - s.height_mm);
      sorted.push_back(off[i]);
    }
  }
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double limit = kFar * 1.4826 * *middle;  // of a normal distribution's standard deviation
  std::vector<char> kept;
  for (const double error : off) {
    kept.push_back(error <= limit ? 1 : 0);  // an unknown one is not
  }
  return kept;
}

// A correction fitted to all levels, or to all but one.
struct Corrected {
  HeightModel model;
  FittedHeights fit;
  std::vector<HeightLevel> levels;  // with what is left of their errors
};

Corrected correct(const Rig& rig, const std::vector<HeightSample>& samples, std::vector<HeightLevel> levels,
                  std::optional<std::size_t> left_out = {}) {
  std::vector<char> used;
  for (const HeightSample& s : samples) {
    used.push_back(s.level == left_out ? 0 : 1);
  }
  const std::size_t count = levels.size() - (left_out ? 1 : 0);
  RigHeights range;
  range.order = kMostFittedOrder;
  range.order_heights = std::min(kMostHeightOrder, static_cast<int>(count) - 2);
  set_range(rig, samples, used, range);
  const auto model = [&] { return HeightModel(rig.camera, range, rig.plane_z_mm, samples, used, levels.size()); };
  const FittedHeights first = choose(model(), rig, range);
  used = without_outliers(samples, used, rig, first.heights);
  HeightModel last_model = model();
  FittedHeights last = choose(last_model, rig, range);
  const HeightCorrection correction(rig.camera, last.heights);
  set_errors(
      samples, rig.camera.columns,
      [&](std::size_t i) {
        const HeightSample& s = samples[i];
        const double geometric = rig.plane_z_mm - s.z;
        return used[i] != 0 ? geometric + correction.at(s.row, s.column, geometric) - s.height_mm : kUnknown;
      },
      levels);
  return {std::move(last_model), std::move(last), std::move(levels)};
}

// How far a level is uneven, as a share of what is allowed. The mean of a part of the columns says more than single
// centroids, whose noise it averages.
double share_of(const HeightLevel& level, const HeightSettings& settings, double rms) {
  const double noise = 4 * rms / std::sqrt(static_cast<double>(level.samples) / kParts);
  return level.uneven_mm / (settings.flatness_mm + settings.tolerance_mm + noise);
}

double greatest_share(const Corrected& all, const HeightSettings& settings) {
  double greatest = 0;
  for (const HeightLevel& level : all.levels) {
    greatest = std::max(greatest, share_of(level, settings, all.fit.rms));
  }
  return greatest;
}

double greatest_uneven(const std::vector<HeightLevel>& levels) {
  double greatest = 0;
  for (const HeightLevel& level : levels) {
    greatest = std::max(greatest, level.uneven_mm);
  }
  return greatest;
}

// Refuses levels of which one is not flat or not at its height. The corrections follow such a level in part, so that
// the greatest error may be at another one. So each level in turn is left out: that one is off without which the others
// fit. Three levels do not tell.
void expect_flat(const Corrected& all, const Rig& rig, const std::vector<HeightSample>& samples,
                 const HeightSettings& settings) {
  constexpr double kAsGood = 2;     // shares that differ by less do not tell one level from the other,
  constexpr double kNothing = 0.2;  // nor do shares of less than this
  if (greatest_share(all, settings) <= 1) {
    return;
  }
  const std::string allowed =
      fmt::format("{} mm of flatness and {} mm of tolerance are allowed", settings.flatness_mm, settings.tolerance_mm);
  std::vector<double> shares;
  std::vector<double> rests;
  for (std::size_t k = 0; k < all.levels.size() && all.levels.size() > kLeastLevels; ++k) {
    const Corrected others = correct(rig, samples, all.levels, k);
    shares.push_back(greatest_share(others, settings));
    rests.push_back(greatest_uneven(others.levels));
  }
  const double least = shares.empty() ? 0 : *std::min_element(shares.begin(), shares.end());
  std::vector<std::size_t> suspects;
  for (std::size_t k = 0; k < all.levels.size(); ++k) {
    if (shares.empty() || shares[k] <= std::min(1.0, std::max(kAsGood * least, kNothing))) {
      suspects.push_back(k);
    }
  }
  if (suspects.empty()) {
    throw UserError("heights", fmt::format("more than one position is not flat, or not at its height; {}", allowed));
  }
  if (suspects.size() > 1) {
    std::vector<std::string> names;
    std::transform(suspects.begin(), suspects.end(), std::back_inserter(names),
                   [&](std::size_t k) { return all.levels[k].name; });
    throw UserError("heights", fmt::format("one position is not flat, or not at its height: {}; {}",
                                           fmt::join(names, " or "), allowed));
  }
  const std::size_t k = suspects.front();
  throw UserError(
      all.levels[k].name,
      fmt::format(
          "is not flat, or not at its height: with it heights are up to {:.3f} mm off, without it {:.3f} mm; {}",
          greatest_uneven(all.levels), rests[k], allowed));
}

}  // namespace

HeightFit fit_heights(const Rig& given, const std::vector<HeightPosition>& positions, const HeightSettings& settings) {
  HeightFit fit;
  Rig rig = given;
  rig.heights.reset();
  std::vector<HeightSample> samples = height_samples(rig, positions, settings);
  fit.levels = levels_of(positions, settings);
  set_errors(
      samples, rig.camera.columns, [&](std::size_t i) { return rig.plane_z_mm - samples[i].z - samples[i].height_mm; },
      fit.levels);
  expect_samples(fit.levels);
  expect_order(fit.levels);
  const cv::Vec4d plane = plane_of(samples);
  expect_scale(rig, plane[3], settings);
  rig = with_belt(rig, plane);
  place_samples(RigOptics(rig), samples);
  const auto geometric = [&](std::size_t i) { return rig.plane_z_mm - samples[i].z; };
  set_errors(
      samples, rig.camera.columns, [&](std::size_t i) { return geometric(i) - samples[i].height_mm; }, fit.levels);
  for (HeightLevel& level : fit.levels) {
    level.before_mean_mm = level.mean_mm;
    level.before_rms_mm = level.rms_mm;
  }
  const Corrected all = correct(rig, samples, fit.levels);
  fit.levels = all.levels;
  fit.rms_mm = all.fit.rms;
  expect_flat(all, rig, samples, settings);
  const HeightCorrection correction(rig.camera, all.fit.heights);
  for (const auto& [row, column, height] : grid_of(rig, all.fit.heights)) {
    fit.correction_mm = std::max(fit.correction_mm, std::abs(correction.at(row, column, height)));
  }
  fit.open_by_tolerance_mm = open_by_levels(all.model, all.fit, rig, settings.tolerance_mm);
  fit.open_by_flatness_mm = settings.flatness_mm;
  fit.open_by_noise_mm = all.fit.uncertain;
  rig.heights = all.fit.heights;
  fit.rig = rig;
  return fit;
}

std::vector<HeightLevel> check_heights(const Rig& rig, const std::vector<HeightPosition>& positions,
                                       const HeightSettings& settings) {
  const std::vector<HeightSample> samples = height_samples(rig, positions, settings);
  std::vector<HeightLevel> levels = levels_of(positions, settings);
  const RigOptics optics(rig);
  set_errors(
      samples, rig.camera.columns,
      [&](std::size_t i) {
        const CameraPlace place{samples[i].row, static_cast<double>(samples[i].column)};
        return rig.plane_z_mm - optics.corrected(place, samples[i].z) - samples[i].height_mm;
      },
      levels);
  return levels;
}

}  // namespace selfproj
