// The correction of heights as a problem of least squares: which orders the samples support, and what they leave open.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_MODEL_H
#define SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_MODEL_H

#include <algorithm>
#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "host/light_section/height_samples.h"
#include "host/rig/height_correction.h"
#include "host/rig/rig.h"

namespace selfproj {

// Least squares of the corrections, from the samples of even and of odd columns apart.
class HeightModel {
 public:
  HeightModel(const RigCamera& camera, const RigHeights& most, double plane_z, const std::vector<HeightSample>& samples,
              const std::vector<char>& used, std::size_t levels)
      : terms_(height_terms(most.order, most.order_heights)),
        correction_(camera, most),
        by_level_(terms_.size(), std::vector<double>(levels, 0)) {
    const auto n = static_cast<int>(terms_.size());
    for (Half& half : halves_) {
      half.matrix = cv::Mat::zeros(n, n, CV_64F);
      half.right = cv::Mat::zeros(n, 1, CV_64F);
    }
    std::vector<double> row;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const HeightSample& s = samples[i];
      if (used[i] == 0) {
        continue;
      }
      const double geometric = plane_z - s.z;
      correction_.terms(s.row, s.column, geometric, row);
      add(row, s.height_mm - geometric, halves_.at(static_cast<std::size_t>(s.column % 2)));
      for (std::size_t t = 0; t < row.size(); ++t) {
        by_level_[t][s.level] += row[t];
      }
    }
  }

  // The terms of a smaller correction, by their places among all.
  [[nodiscard]] std::vector<int> places(int order, int order_heights) const {
    std::vector<int> places;
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      const auto& [column, row, height] = terms_[i];
      if (column + row + height <= order && height <= order_heights) {
        places.push_back(static_cast<int>(i));
      }
    }
    return places;
  }

  struct Solved {
    cv::Mat inverse;       // of the normal matrix
    cv::Mat coefficients;  // n x 1
  };
  // `which`: 0 even columns, 1 odd ones, 2 all.
  [[nodiscard]] std::optional<Solved> solve(const std::vector<int>& places, int which) const {
    const Half half = of(which);
    const auto n = static_cast<int>(places.size());
    cv::Mat matrix(n, n, CV_64F);
    cv::Mat right(n, 1, CV_64F);
    for (int i = 0; i < n; ++i) {
      const int from = places[static_cast<std::size_t>(i)];
      right.at<double>(i) = half.right.at<double>(from);
      for (int k = 0; k < n; ++k) {
        matrix.at<double>(i, k) = half.matrix.at<double>(from, places[static_cast<std::size_t>(k)]);
      }
    }
    Solved solved;
    if (cv::invert(matrix, solved.inverse, cv::DECOMP_CHOLESKY) == 0) {
      return std::nullopt;
    }
    solved.coefficients = solved.inverse * right;
    return solved;
  }

  // The mean square error of the coefficients on the samples of `which`.
  [[nodiscard]] double error(const std::vector<int>& places, const cv::Mat& coefficients, int which) const {
    const Half half = of(which);
    double sum = half.square;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double at = coefficients.at<double>(static_cast<int>(i));
      sum -= 2 * at * half.right.at<double>(places[i]);
      for (std::size_t k = 0; k < places.size(); ++k) {
        sum += at * coefficients.at<double>(static_cast<int>(k)) * half.matrix.at<double>(places[i], places[k]);
      }
    }
    return std::max(0.0, sum) / half.count;
  }

  [[nodiscard]] std::size_t levels() const { return by_level_.front().size(); }

  // The sum of a term over the samples of a level.
  [[nodiscard]] double sum_of_level(int place, std::size_t level) const {
    return by_level_[static_cast<std::size_t>(place)][level];
  }

 private:
  struct Half {
    cv::Mat matrix, right;
    double square = 0, count = 0;
  };
  static void add(const std::vector<double>& row, double off, Half& half) {
    const auto n = static_cast<int>(row.size());
    for (int i = 0; i < n; ++i) {
      auto* to = half.matrix.ptr<double>(i);
      const double at = row[static_cast<std::size_t>(i)];
      for (int k = 0; k < n; ++k) {
        to[k] += at * row[static_cast<std::size_t>(k)];
      }
      half.right.at<double>(i) += at * off;
    }
    half.square += off * off;
    half.count += 1;
  }
  [[nodiscard]] Half of(int which) const {
    if (which < 2) {
      return halves_.at(static_cast<std::size_t>(which));
    }
    return {halves_[0].matrix + halves_[1].matrix, halves_[0].right + halves_[1].right,
            halves_[0].square + halves_[1].square, halves_[0].count + halves_[1].count};
  }

  std::vector<std::array<int, 3>> terms_;
  HeightCorrection correction_;
  std::vector<std::vector<double>> by_level_;
  std::array<Half, 2> halves_;
};

// A correction of one order, fitted to all samples.
struct FittedHeights {
  RigHeights heights;
  std::vector<int> places;
  HeightModel::Solved solved;
  double rms = 0;
  double uncertain = 0;  // greatest standard deviation by noise on the grid
};

// The smallest correction that predicts the other half of the columns as well as any, among those of at most the orders
// of `range` that the samples determine. Throws UserError if there is none.
FittedHeights choose(const HeightModel& model, const Rig& rig, const RigHeights& range);

// What heights move by if each level is off by the tolerance, in the worst way, anywhere in the image, mm.
double open_by_levels(const HeightModel& model, const FittedHeights& fit, const Rig& rig, double tolerance);

// Places (row, column, height) over the image and the calibrated heights.
std::vector<std::array<double, 3>> grid_of(const Rig& rig, const RigHeights& heights);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_MODEL_H
