#ifndef SELFPROJ_HOST_CALIBRATION_MEDIAN_H
#define SELFPROJ_HOST_CALIBRATION_MEDIAN_H

#include <algorithm>
#include <cstddef>
#include <vector>

namespace selfproj {

// The median of values, at least one; of an even number of them the upper of the two in the middle.
inline double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_MEDIAN_H
