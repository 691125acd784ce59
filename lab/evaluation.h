// Errors of many points, and points that are missing.
#ifndef SELFPROJ_LAB_EVALUATION_H
#define SELFPROJ_LAB_EVALUATION_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "selfproj/images/float_image.h"

namespace selfproj::lab {

class ErrorSpread {
 public:
  // The error of a place, mm; NaN: it has no point.
  void add(double error) {
    if (std::isnan(error)) {
      ++missing_;
    } else {
      errors_.push_back(static_cast<float>(std::abs(error)));
    }
  }
  void add(const ErrorSpread& other) {
    errors_.insert(errors_.end(), other.errors_.begin(), other.errors_.end());
    missing_ += other.missing_;
  }

  [[nodiscard]] std::size_t points() const { return errors_.size(); }

  // The share of places without a point, 0..1.
  [[nodiscard]] double missing() const {
    return static_cast<double>(missing_) / static_cast<double>(missing_ + errors_.size());
  }

  // The share of the points whose error is greater than this; NaN without points.
  [[nodiscard]] double beyond(double most) const {
    const auto count =
        std::count_if(errors_.begin(), errors_.end(), [&](float error) { return static_cast<double>(error) > most; });
    return static_cast<double>(count) / static_cast<double>(errors_.size());
  }

  // NaN without points.
  [[nodiscard]] double rms() const {
    double sum = 0;
    for (const float error : errors_) {
      sum += static_cast<double>(error) * static_cast<double>(error);
    }
    return std::sqrt(sum / static_cast<double>(errors_.size()));
  }

  // The error that this share of the points does not exceed, 0..1; 1: the largest. NaN without points.
  [[nodiscard]] double quantile(double share) const {
    if (errors_.empty()) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    std::vector<float> sorted = errors_;
    const auto at = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(sorted.size()))) - 1;
    const auto place = sorted.begin() + std::max<std::ptrdiff_t>(at, 0);
    std::nth_element(sorted.begin(), place, sorted.end());
    return static_cast<double>(*place);
  }

 private:
  std::vector<float> errors_;  // magnitudes
  std::size_t missing_ = 0;
};

// Compares measured heights and differences with the truth. In all maps rows are frames and columns are image columns;
// values are in mm, NaN if there is none. Masks have one entry for each entry of the map.

using Mask = std::vector<std::uint8_t>;

// The true height over the plane at a place (x, y) of the camera's frame during frame `frame` (from 0).
using TrueHeight = std::function<double(int frame, double x, double y)>;

// 1 for the entries within `columns` columns or `rows` rows of a step of the map `truth`, and for those without a
// value. There a line of finite width lies on two heights at the same time. A step is where two neighbours, along a row
// or along a column, differ by more than `min_step`, or only one of them has a value. An entry beside a step is within
// 1 of it.
Mask near_steps(const images::FloatImage& truth, double min_step, int columns, int rows);

// The same within a rectangle: 1 for the entries that are within `columns` >= 1 columns and `rows` >= 1 rows of a step,
// those beside its corners as well. Hidden rigs are judged alike (lab/scripts/hidden_rig_figures.py), where
// a step along the belt is one over 0.7 mm.
Mask around_steps(const images::FloatImage& truth, double min_step, int columns, int rows);

struct HeightErrors {
  std::int64_t points = 0;    // points compared
  std::int64_t left_out = 0;  // points left out near steps
  std::int64_t missing = 0;   // entries without a point that are not near steps
  double max = 0;             // largest magnitude
  double rms = 0;
  double mean = 0;

  // The share of entries without a point among those that are not near steps, 0..1.
  [[nodiscard]] double missing_share() const {
    return points + missing > 0 ? static_cast<double>(missing) / static_cast<double>(points + missing) : 0;
  }
};

// Compares each point's height with the truth at its own x and y. Throws std::invalid_argument if the sizes differ.
HeightErrors height_errors(const images::FloatImage& height, const images::FloatImage& x, const images::FloatImage& y,
                           const Mask& left_out, const TrueHeight& truth);

// The values of a map where the mask is `label`.
struct RegionValues {
  std::int64_t count = 0;  // if 0, the others are NaN
  double mean = 0;
  double median = 0;
};
RegionValues values_in(const images::FloatImage& map, const Mask& mask, std::uint8_t label);

// How far a region lies below its surroundings in the map `difference` (positive towards the camera). It is the
// difference of the medians, so that points at the edges do not count. NaN if either is empty.
double depth_of(const images::FloatImage& difference, const Mask& mask, std::uint8_t region, std::uint8_t surroundings);

// max - min of the centroids C in each row (frame), over entries where `left_out` is 0. Rows with fewer than two do not
// count. If no row counts, all values are 0.
struct CentroidRange {
  double greatest = 0;  // over the rows
  double median = 0;
};
CentroidRange centroid_range(const images::FloatImage& centroid, const Mask& left_out, int first_row, int rows);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_EVALUATION_H
