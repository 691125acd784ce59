// Errors of many points, and points that are missing.
#ifndef SELFPROJ_LAB_ERROR_SPREAD_H
#define SELFPROJ_LAB_ERROR_SPREAD_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace selfproj {

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

}  // namespace selfproj

#endif  // SELFPROJ_LAB_ERROR_SPREAD_H
