#include "host/light_section/height_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "host/files/user_error.h"

namespace selfproj {

std::vector<std::array<double, 3>> grid_of(const Rig& rig, const RigHeights& heights) {
  constexpr int kSteps = 8;
  std::vector<std::array<double, 3>> grid;
  for (int r = 0; r <= kSteps; ++r) {
    for (int c = 0; c <= kSteps; ++c) {
      for (int h = 0; h <= kSteps; ++h) {
        grid.push_back({r * (rig.camera.rows - 1.0) / kSteps, c * (rig.camera.columns - 1.0) / kSteps,
                        heights.lowest_mm + h * (heights.highest_mm - heights.lowest_mm) / kSteps});
      }
    }
  }
  return grid;
}

namespace {

constexpr double kMostUncertain = 0.02;  // mm, one standard deviation by noise: more is not determined

cv::Mat terms_at(const HeightCorrection& correction, const std::array<double, 3>& place) {
  std::vector<double> values;
  correction.terms(place[0], place[1], place[2], values);
  cv::Mat terms(static_cast<int>(values.size()), 1, CV_64F);
  std::copy(values.begin(), values.end(), terms.begin<double>());
  return terms;
}

std::optional<FittedHeights> fitted(const HeightModel& model, const Rig& rig, const RigHeights& range, int order,
                                    int order_heights) {
  FittedHeights fit{range, model.places(order, order_heights), {}};
  const auto solved = model.solve(fit.places, 2);
  if (!solved) {
    return std::nullopt;
  }
  fit.solved = *solved;
  fit.heights.order = order;
  fit.heights.order_heights = std::min(order, order_heights);
  fit.heights.corrections_mm.assign(solved->coefficients.begin<double>(), solved->coefficients.end<double>());
  fit.rms = std::sqrt(model.error(fit.places, solved->coefficients, 2));
  const HeightCorrection correction(rig.camera, fit.heights);
  for (const auto& place : grid_of(rig, fit.heights)) {
    const cv::Mat terms = terms_at(correction, place);
    const cv::Mat variance = terms.t() * solved->inverse * terms;
    fit.uncertain = std::max(fit.uncertain, fit.rms * std::sqrt(std::max(0.0, variance.at<double>(0))));
  }
  return fit;
}

}  // namespace

FittedHeights choose(const HeightModel& model, const Rig& rig, const RigHeights& range) {
  constexpr double kAsWell = 1.002;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  struct Candidate {
    int order;
    double error;
  };
  std::vector<Candidate> candidates;
  double least = kNone;
  double uncertain = kNone;
  for (int order = 1; order <= range.order; ++order) {
    const std::optional<FittedHeights> fit = fitted(model, rig, range, order, range.order_heights);
    uncertain = fit && order == 1 ? fit->uncertain : uncertain;
    if (!fit || fit->uncertain > kMostUncertain) {
      continue;
    }
    double error = 0;
    for (const int half : {0, 1}) {
      if (const auto solved = model.solve(fit->places, half)) {
        error += model.error(fit->places, solved->coefficients, 1 - half);
      } else {
        error = kNone;
      }
    }
    candidates.push_back({order, error});
    least = std::min(least, error);
  }
  for (const Candidate& candidate : candidates) {
    if (candidate.error <= kAsWell * kAsWell * least) {
      return *fitted(model, rig, range, candidate.order, range.order_heights);
    }
  }
  throw UserError("heights", fmt::format("the positions do not determine the heights of the whole image (a standard "
                                         "deviation of {:.3g} mm somewhere, {} is allowed); add positions, or lines",
                                         uncertain, kMostUncertain));
}

double open_by_levels(const HeightModel& model, const FittedHeights& fit, const Rig& rig, double tolerance) {
  const HeightCorrection correction(rig.camera, fit.heights);
  std::vector<cv::Mat> responses;
  for (std::size_t k = 0; k < model.levels(); ++k) {
    cv::Mat right(static_cast<int>(fit.places.size()), 1, CV_64F);
    for (std::size_t i = 0; i < fit.places.size(); ++i) {
      right.at<double>(static_cast<int>(i)) = model.sum_of_level(fit.places[i], k);
    }
    responses.emplace_back(fit.solved.inverse * right);
  }
  double greatest = 0;
  for (const auto& place : grid_of(rig, fit.heights)) {
    const cv::Mat terms = terms_at(correction, place);
    double sum = 0;
    for (const cv::Mat& response : responses) {
      sum += std::abs(terms.dot(response));
    }
    greatest = std::max(greatest, tolerance * sum);
  }
  return greatest;
}

}  // namespace selfproj
