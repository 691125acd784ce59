// Compares depth images of a scene with the true depths.
#ifndef SELFPROJ_SIM_COSIM_DEPTH_ERRORS_H
#define SELFPROJ_SIM_COSIM_DEPTH_ERRORS_H

#include <cmath>
#include <cstddef>
#include <limits>

#include "host/images/float_image.h"

namespace selfproj {

// Over the pixels of all images with both a measured and a true depth; NaN if there were none.
class DepthErrors {
 public:
  // Adds images of one size, mm.
  void add(const FloatImage& depth, const FloatImage& truth) {
    constexpr double kFar = 15;  // mm: a larger error comes from a wrong code or match, not from quantization
    for (std::size_t i = 0; i < truth.values.size(); ++i) {
      const auto error = static_cast<double>(depth.values[i] - truth.values[i]);
      if (std::isnan(error)) {
        continue;
      }
      ++seen_;
      if (std::abs(error) > kFar) {
        ++far_off_;
      } else {
        ++near_;
        squares_ += error * error;
      }
    }
  }

  [[nodiscard]] double seen() const { return seen_; }
  // RMS error in mm of the pixels that are no more than 15 mm off.
  [[nodiscard]] double rms() const { return near_ > 0 ? std::sqrt(squares_ / near_) : kNone; }
  // Share of the other pixels, 0..1.
  [[nodiscard]] double far_off() const { return seen_ > 0 ? far_off_ / seen_ : kNone; }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double seen_ = 0, near_ = 0, far_off_ = 0, squares_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_DEPTH_ERRORS_H
